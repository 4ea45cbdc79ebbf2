"""Oracle: xacro's own evaluation, which is Python's."""

import pytest
import xacro

from workbench.plant.formats.xacro_expressions import evaluate, type_of

SAME = """
1 + 2 * 3 - 4 / 5
7 // 2, 7 % 3, 2 ** 10, -2 ** 2, ~5, +3, not 0
1 << 4 | 3 & 6 ^ 1, 64 >> 3
0.0833333 * mass * (3 * r * r + l * l)
1 < 2 < 3, 3 > 2 > 2, 1 == 1.0, 1 != 2, 2 <= 2, 3 >= 4
mass is None, None is None, None is not None, [] is [], [] is not []
'x' in 'xyz', 'q' not in 'xyz', 2 in [1, 2], 'a' in settings
True and 0 or 'else', '' and 1 / 0, 1 or 1 / 0
l / 2.0 if 'x' in direction else 0
1e-3, 1_000, 0x1F, 3j, 'a' 'b', b'ab', ...
[1, 2, *[3, 4]], (1, *'ab'), {1, *{2}}, {'a': 1, **settings}
[1, 2, 3][0], [1, 2, 3][-1], [1, 2, 3, 4][1:3], 'abcdef'[::-2], [1, 2, 3][:2]
{'a': {'b': [1, 2]}}['a']['b'][1]
[x * x for x in range(5) if x % 2 if x > 1]
[(x, y) for x in 'ab' for y in range(2)]
[a + b for a, (b, c) in [(1, (2, 3))]]
{k: v for k, v in zip('ab', [1, 2])}, {x % 2 for x in range(9)}
sum(x for x in range(10)), max(i * i for i in [1, -4]), list(map(lambda x: x + 1, [1, 2]))
[x for x in [x for x in range(3)]]
[f() for f in [lambda: i for i in range(3)]]
(lambda a, b=2: a * b)(3), (lambda a, b=2: a * b)(3, b=5), (lambda: 7)()
python.sorted([3, 1, 2], key=lambda x: -x), python.list(python.filter(lambda x: x > 1, [1, 2]))
python.list(python.enumerate('ab')), python.list(python.reversed([1, 2])), python.abs(-1)
python.isinstance(1, python.int), python.any([0, 1]), python.all([]), python.divmod(7, 2)
python.type('') == python.str, python.ord('a'), python.repr('a'), python.tuple([1]), python.set()
f"{mass:.3f} {direction!r} {l:{2 + 4}.2f}", f'{mass}', f'a{{b}}'
'%s %d %.2f %(a)s' % {'a': 1} if 0 else '%d %.2f' % (3, 2.5)
'{} {:.2f} {1}'.format if 0 else '{} {:.2f}'.format(1, 2.5)
'{0} {1[0]} {a} {a:>5} {b[k]} {0.real}'.format(1, [7], a=2, b={'k': 3}), '{a}'.format_map({'a': 4})
str.format('{}', 1), str.join(',', 'ab'), dict.fromkeys('ab', 0), float.fromhex('0x1p3')
'aBc'.lower(), ' a '.strip(), 'a,b'.split(','), '-'.join(['a', 'b']), 'abc'.replace('b', 'x')
'abc'.startswith('a'), 'abc'.find('c'), 'a'.upper().isalpha(), 'x'.zfill(3), 'a\\tb'.expandtabs(2)
[3, 1].index(1), [1, 1].count(1), {'a': 1}.get('b', 2), list({'a': 1}.items()), {'a': 1}.copy()
(1.5).is_integer(), (5).bit_length(), (2.0).hex(), (1 + 2j).imag, (1.25).as_integer_ratio()
range(2, 9, 3)[1], range(5).stop, python.slice(1, 2).start
sin(pi / 2), math.cos(0), math.atan2(1, 1), radians(180), degrees(pi), sqrt(2), hypot(3, 4), inf
math.floor(1.5), ceil(1.2), fabs(-1), math.isnan(nan), log10(100), e, tau
min(1, 2), max([1, 5]), round(2.567, 2), len('abc'), int('5'), float('1e3'), bool(0), str(1.0)
xacro.tokenize('a, b;c'), tokenize('1 2'), xacro.dotify({'a': {'b': 3}}).a.b
tree.a.b[0].c, tree['a']['b'][1], tree.get('a') == tree.a, [x.c for x in tree.a.b[:1]], tree._b
space.mass, space.inner.r, space.mass + 1
sorted([2, 1]), range(3), load_yaml
xacro.fatal('a', 1)
xacro.message('a'), xacro.warning('b')
nothing
settings.gone
tree.gone
space.gone
1 / 0
[][1]
{}['a']
'a' + 1
int('x')
(lambda a: a)()
(lambda a: a)(1, 2)
(lambda a: a)(1, a=2)
[a for a, b in [(1, 2, 3)]]
1 +
a b
((((1
"""
"""One a line; a line that is an error must be the same kind of error."""
REFUSED = """
().__class__
''.__class__.__mro__
(lambda x: x.__class__.__base__.__subclasses__())(1)
[x.__class__ for x in [1]]
__import__('os').system('true')
__builtins__
'{0.__class__}'.format(1)
'{a.__class__.__mro__}'.format_map({'a': 1})
str.format('{0.__class__}', 1)
f'{().__class__}'
sin.__self__
math.sin.__self__
(lambda: 1).__globals__
(lambda: 1).__code__
(lambda: 1).func
xacro.load_yaml.__globals__
load_yaml.__closure__
xacro.tokenize.__globals__['os']
(x for x in [1]).gi_frame
(x for x in [1]).gi_frame.f_back.f_globals
'a'.format.func
str.mro()
python.type('X', (), {})
python.type(python.type)
python.type(sin)
python.type(x for x in [1])
python.vars(math)
python.vars()
math.parent
math.root
math.update(sin=1)
python.map.__self__
map(str.__subclasses__, [1])
(y := 5)
open('/etc/passwd')
eval('1')
exec('1')
getattr(1, 'real')
globals()
lambda *a: a
print(1)
"""


def lines(text: str) -> list[str]:
    return text.strip().splitlines()


@pytest.fixture
def symbols(monkeypatch):
    monkeypatch.setattr(xacro, "filestack", ["a.xacro"])
    return made_symbols()


def made_symbols():
    """The names of a file: xacro's, and some properties."""
    table = xacro.Table(xacro.create_global_symbols())
    space, inner = xacro.NameSpace(), xacro.NameSpace()
    inner["r"] = "2"
    space["mass"], space["inner"] = "${2 * 3}", inner
    for name, value in {
        "mass": "1.5",
        "r": "0.1",
        "l": "${2 * r}",
        "direction": "xy",
        "settings": {"a": 1},
        "tree": xacro.YamlDictWrapper({"a": {"b": [{"c": 1}, 2]}, "_b": 3}),
        "space": space,
    }.items():
        table[name] = value
    return table


def outcome(of, text: str, symbols) -> tuple[type, str]:
    """Return the type and text of a value, or those of an error."""
    try:
        value = of(text, symbols)
    except Exception as error:
        return type(error), ""
    return type(value), repr(value)


def test_a_value_is_that_of_xacro(monkeypatch, case):
    monkeypatch.setattr(xacro, "filestack", ["a.xacro"])
    for text in lines(SAME):
        with case(text):
            symbols = made_symbols()
            expected = outcome(xacro.safe_eval, text, symbols)
            assert outcome(evaluate, text, symbols) == expected


def test_nothing_but_data_is_reached(monkeypatch, case):
    """With the two functions as the child replaces them."""
    monkeypatch.setattr(xacro, "filestack", ["a.xacro"])
    for text in lines(REFUSED):
        with case(text):
            symbols = made_symbols()
            symbols.root["python"]["type"] = type_of
            dict.pop(symbols.root["python"], "vars")
            with pytest.raises(
                (AttributeError, NameError, SyntaxError, TypeError, xacro.XacroException)
            ):
                evaluate(text, symbols)


def test_a_list_of_mappings_of_yaml_is_walked_as_in_xacro(symbols):
    symbols["rows"] = xacro.YamlListWrapper([{"x": 1}, {"x": 2}])
    text = "[row.x for row in rows], rows[0].x, rows[-1]['x']"
    assert evaluate(text, symbols) == xacro.safe_eval(text, symbols) == ([1, 2], 1, 2)


def test_a_power_of_gigabits_is_refused_at_once(symbols):
    """Python would compute it without a pause in which a signal could stop it."""
    for text in ("12.3/2670**4294967296", "(-3)**(10**9)", "True and 2**100001"):
        with pytest.raises(OverflowError, match="too large"):
            evaluate(text, symbols)
    for text in ("2**1000", "2.0**3", "2**-4000000000", "1**0", "(-2)**3"):
        assert outcome(evaluate, text, symbols) == outcome(xacro.safe_eval, text, symbols)

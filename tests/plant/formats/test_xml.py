"""XML from strangers: line numbers, and bounds."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.formats import xml
from workbench.plant.formats.xml import element_location, parse_xml, read_xml


@pytest.fixture
def write(tmp_path):
    def write_bytes(data: bytes):
        path = tmp_path / "a.xml"
        path.write_bytes(data)
        return path

    return write_bytes


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read_xml(path)
    assert str(caught.value).startswith(str(path))
    return str(caught.value)


def test_elements_know_their_lines(write):
    path = write(b"<a>\n <b/>\n <c>\n  <d/>\n </c>\n</a>")
    root = read_xml(path)
    assert [element.line for element in root.iter()] == [1, 2, 3, 4]
    assert element_location(root[1]) == f"{path}:3"


def test_empty_lines_before_the_declaration_do_not_matter(write):
    root = read_xml(write(b'\n\n<?xml version="1.0"?>\n<a><b/></a>'))
    assert root[0].line == 4


def test_two_hyphens_in_a_comment_do_not_matter(write):
    root = read_xml(write(b"<a>\n<!-- -- \n -->\n<b/></a>"))
    assert root[0].line == 4


def test_a_text_made_from_a_file_has_no_lines(tmp_path):
    path = tmp_path / "a.xacro"
    assert element_location(parse_xml("<a>\n<b/></a>", path)[0]) == str(path)


@pytest.mark.parametrize(
    "data",
    [
        b'<?xml version="1.0" encoding="ISO-8859-1"?><a b="\xfc"/>',
        '<?xml version="1.0" encoding="UTF-16"?><a b="ü"/>'.encode("utf-16"),
        '\ufeff<a b="ü"/>'.encode(),
    ],
)
def test_an_encoding_is_read_as_declared(write, data):
    assert read_xml(write(data)).get("b") == "ü"


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"<a>\n<b></a>", ":2: not XML: mismatched tag"),
        (b"", ":1: not XML: no element found"),
        (b"<a>\xff</a>", "not XML"),
        (b'<?xml version="1.0" encoding="bogus"?><a/>', "not XML: unknown encoding"),
        (b'<!DOCTYPE a [\n<!ENTITY x "y">]><a>&x;</a>', ":2: it declares its own entities"),
        (b"<a>" * 101 + b"</a>" * 101, "nested more than 100 deep"),
    ],
)
def test_what_is_not_xml_of_ours_is_refused(write, data, said):
    assert said in fault(write(data))


def test_an_entity_bomb_ends_at_its_first_declaration(write):
    lines = ['<!ENTITY a0 "ha">']
    lines += [f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 12)]
    bomb = f"<!DOCTYPE a [\n{chr(10).join(lines)}\n]><a>&a11;</a>"
    assert ":2: it declares its own entities" in fault(write(bomb.encode()))


def test_an_external_file_is_not_read(write, tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("<b/>")
    bait = f'<!DOCTYPE a SYSTEM "{secret}"><a/>'
    assert len(read_xml(write(bait.encode()))) == 0


def test_too_many_elements_are_refused(write, monkeypatch):
    monkeypatch.setattr(xml, "MAX_XML_ELEMENTS", 10)
    assert "more than 10 elements" in fault(write(b"<a>" + b"<b/>" * 10 + b"</a>"))


def test_too_large_a_file_is_refused(write, monkeypatch):
    monkeypatch.setattr(xml, "MAX_XML_BYTES", 10)
    assert "larger than" in fault(write(b"<a>         </a>"))


def test_a_missing_file_is_said(tmp_path):
    assert "no such file" in fault(tmp_path / "nothing.sdf")

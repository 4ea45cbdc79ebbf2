"""`workbench params`."""

from workbench.common.resources import find_model
from workbench.control.controller_file import load_controller
from workbench.gains.gain_choice import flight_gains
from workbench.parameters.parameter_table import vehicle_parameters
from workbench.plant.loading import load_vehicle

ROWS = vehicle_parameters(load_vehicle(find_model("dh_drone")), load_controller().table)


def test_the_table_has_a_line_for_every_parameter_of_the_vehicle(run):
    said = run("params")
    assert said.code == 0
    header, *lines = said.out.splitlines()
    assert header.split() == ["name", "value", "unit", "min", "max", "default", "help"]
    assert [line.split()[0] for line in lines] == [row.name for row in ROWS]
    assert max(map(len, lines)) < 160


def test_columns_line_up(run):
    header, *lines = run("params").out.splitlines()
    assert {line[header.index("unit") - 1] for line in lines} == {" "}
    assert {line[header.index("help") - 1] for line in lines} == {" "}


def test_json_has_the_values_of_the_models_own_gains(run):
    rows = run("params", "--json").json["parameters"]
    values = flight_gains(load_vehicle(find_model("dh_drone")))
    assert {row["name"]: row["value"] for row in rows} == {
        row.name: values[row.name] for row in ROWS
    }
    for row, parameter in zip(rows, ROWS, strict=True):
        assert (row["unit"], row["min"], row["max"], row["default"], row["help"]) == (
            parameter.unit,
            parameter.minimum,
            parameter.maximum,
            parameter.default,
            parameter.help,
        )


def test_a_gain_file_goes_on_top(run, write):
    gains = write("gains.yaml", "gains: {kp_roll: 123.0}\n")
    rows = run("params", "--json", "--gains", gains).json["parameters"]
    assert next(row["value"] for row in rows if row["name"] == "kp_roll") == 123.0


def test_a_bad_gain_file_is_named_with_its_line(case, refused, write):
    for text, line, word in [
        ("gains:\n  kp_roll: .nan\n", 2, "kp_roll"),
        ("gains:\n  kp_roll: 100.0\n  kd_roll: 1000.0\n", 3, "0 .. 150 1/s"),
        ("gains:\n  kp_rol: 1.0\n", 2, "did you mean 'kp_roll'?"),
        ("gains:\n  kp_roll: much\n", 2, "number"),
        ("gains:\n  kp_roll: 1.0\n  kp_roll: 2.0\n", 3, "second time"),
        ("gains:\n  1: 2\n", 2, "unknown parameter '1'"),
        ("gain:\n  kp_roll: 1.0\n", 1, "did you mean 'gains'?"),
        ("gains: [1, 2\n", 2, "not YAML"),
        ("gains: [1, 2]\n", 1, "NAME: VALUE"),
        ("", 1, "key: value"),
    ]:
        with case(text, line, word):
            path = write("bad.yaml", text)
            sentence = refused("params", "--gains", path)
            assert f"{path}:{line}: " in sentence
            assert word in sentence


def test_a_missing_gain_file_and_an_unknown_model_are_named(refused, tmp_path):
    assert "gone.yaml: no such file" in refused("params", "--gains", tmp_path / "gone.yaml")
    assert "dh_drone" in refused("params", "--model", "dh_dron")


def test_the_rows_are_those_of_the_controller_that_is_named(run):
    said = run("params", "--controller", "pid", "--set", "kp_tilt=7.5", "--json")
    assert said.code == 0, said.err
    values = {row["name"]: row["value"] for row in said.json["parameters"]}
    assert values["kp_tilt"] == 7.5
    assert "kp_roll" not in values

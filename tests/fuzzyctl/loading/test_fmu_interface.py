"""FMUs that rule files name: read without running them, mistakes at the place that names them."""

import zipfile

import pytest

from fuzzyctl import Plant, dumps, load
from fuzzyctl.testing import check_text
from tests.fuzzyctl.simulation.test_fmu_archive import FMI2


@pytest.fixture
def found(tmp_path):
    def look(text, description=FMI2):
        with zipfile.ZipFile(tmp_path / "m.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", description)
        (tmp_path / "text.fmu").write_text("hello", encoding="utf-8")
        return check_text(text, str(tmp_path / "p.fz"), folder=tmp_path)

    return look


def test_inputs_and_outputs_are_those_of_the_fmu(found, tmp_path):
    (plant,), _ = found('plant p "Body" = fmu("m.fmu")\nparam not_ = 3\n')
    assert plant.external == plant.fmu == str(tmp_path / "m.fmu")
    assert [s.name for s in plant.inputs] == ["u"]
    assert [(s.name, s.label, s.unit) for s in plant.results] == [("body_x_1", "place", "m")]
    assert plant.states == ()
    assert 'plant p "Body" = fmu("m.fmu")' in dumps(plant)
    (tmp_path / "q.fz").write_text(dumps(plant), encoding="utf-8")
    assert load(tmp_path / "q.fz", block=Plant) == plant


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            'fmu("text.fmu")',
            ("FZ218", '"text.fmu" cannot be used: the file is not a zip archive, so it is not an FMU', '"text.fmu"'),
        ),
        (
            'fmu("gone.fmu")',
            ("FZ218", '"gone.fmu" cannot be used: there is no such file', '"gone.fmu"'),
        ),
        ('fmu("/m.fmu")', ("FZ218", "'/m.fmu' lies outside the folder of this file", '"/m.fmu"')),
        ('fmu("m.fmu")\nparam iff = 3', ("FZ202", "the FMU has no parameter 'iff'", "iff")),
        ('fmu("m.fmu")\ninput u', ("FZ214", "'input' does not go with a plant of one line", "input")),
    ],
)
def test_mistakes_are_where_they_are_written(found, text, expected):
    (mistake,) = [d for d in found(f"plant p = {text}\n")[1] if d.severity == "error"]
    code, message, place = expected
    assert mistake.code == code
    assert mistake.message.startswith(message)
    assert mistake.span.text == place


def test_an_fmu_for_model_exchange_is_refused_with_a_repair(found):
    (mistake,) = found('plant p = fmu("m.fmu")\n', FMI2.replace("CoSimulation", "ModelExchange"))[1]
    assert mistake.message == '"m.fmu" cannot be used: the FMU is not for co-simulation'
    assert mistake.facts == ("it is for: ModelExchange",)
    assert mistake.help == "export it for co-simulation"


def test_a_name_that_is_nearly_there_is_suggested(found):
    (mistake,) = found('plant p = fmu("n.fmu")\n')[1]
    assert mistake.help == "did you mean 'm.fmu'?"
    (mistake,) = (d for d in found('plant p = fmu("m.fmu")\nparam nut_ = 3\n')[1] if d.severity == "error")
    assert mistake.help == "did you mean 'not_'?"


def test_an_fmu_for_other_machines_is_a_warning_that_names_them(found):
    (warning,) = found('plant p = fmu("m.fmu")\n')[1]
    assert (warning.code, warning.severity, warning.span.text) == ("FZ712", "warning", '"m.fmu"')
    assert warning.message == "the FMU has no binary for this machine"
    assert warning.facts[0].startswith("it has binaries for: no machine; this is ")

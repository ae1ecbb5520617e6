"""Descriptions of FMUs, and archives that are none, or that would write elsewhere or fill the disk."""

import os
import stat
import zipfile

import pytest

from fuzzyctl.simulation import fmu_archive
from fuzzyctl.simulation.fmu_archive import FmuError, FmuVariable, identifier, read_description, unpack
from tests.effort import at_most

FMI2 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g">
  <CoSimulation modelIdentifier="m"><SourceFiles><File name="m.c"/></SourceFiles></CoSimulation>
  <ModelVariables>
    <ScalarVariable name="body.x[1]" valueReference="7" causality="output" description="place">
      <Real unit="m"/>
    </ScalarVariable>
    <ScalarVariable name="u" valueReference="1" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="1" causality="input"><Boolean start="false"/></ScalarVariable>
    <ScalarVariable name="not" valueReference="2" causality="parameter"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="inner" valueReference="3"><Real/></ScalarVariable>
  </ModelVariables>
</fmiModelDescription>
"""
FMI3 = """<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="g">
  <CoSimulation modelIdentifier="m"/>
  <ModelVariables>
    <Float64 name="u" valueReference="1" causality="input" start="0"/>
    <Float64 name="many" valueReference="2" causality="input" start="0 0"><Dimension start="2"/></Float64>
    <Int32 name="n" valueReference="4" causality="input" start="0"/>
    <Float64 name="y" valueReference="5" causality="output"/>
  </ModelVariables>
</fmiModelDescription>
"""


@pytest.fixture
def archive(tmp_path):
    def write(files, name="m.fmu"):
        with zipfile.ZipFile(tmp_path / name, "w") as made:
            for entry, content in files.items():
                made.writestr(entry, content)
        return str(tmp_path / name)

    return write


def test_what_an_fmu_says_of_itself(archive):
    files = {"modelDescription.xml": FMI2, "binaries/linux64/m.so": b"", "binaries/win64/m.dll": b"", "sources/m.c": ""}
    found = read_description(archive(files | {"binaries/win64/other.dll": b"", "binaries/darwin64/other.dylib": b""}))
    assert (found.version, found.model, found.platforms, found.has_sources) == (2, "m", ("linux64", "win64"), True)
    assert found.inputs == (FmuVariable("u", "u", 1),)
    assert found.outputs == (FmuVariable("body.x[1]", "body_x_1", 7, "place", "m"),)
    assert found.params == (FmuVariable("not", "not_", 2),)
    third = read_description(archive({"modelDescription.xml": FMI3}))
    assert (third.version, third.platforms, third.has_sources) == (3, (), False)
    assert [v.name for v in (*third.inputs, *third.outputs)] == ["u", "y"]


def test_many_variables_are_read_in_a_time_that_grows_with_their_number(archive):
    many = "".join(f'<ScalarVariable name="x{k}" valueReference="{k}"><Real/></ScalarVariable>' for k in range(60_000))
    path = archive({"modelDescription.xml": FMI2.replace("</ModelVariables>", many + "</ModelVariables>")})
    with at_most(4):
        assert read_description(path).outputs[0].reference == 7


@pytest.mark.parametrize(
    ("name", "expected"),
    [("der(x)", "der_x"), ("1st", "v1st"), ("σ*", "σ"), ("a b", "a_b"), ("*", "v"), ("and", "and_")],
)
def test_names_become_those_of_rule_files(name, expected):
    assert identifier(name) == expected


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("CoSimulation", "ModelExchange"), "the FMU is not for co-simulation"),
        (('fmiVersion="2.0"', 'fmiVersion="1.0"'), "the FMU is one of FMI 1.0, not 2.0 or 3.0"),
        (("fmiModelDescription", "other"), "modelDescription.xml describes no FMU"),
        (('modelIdentifier="m"', 'modelIdentifier="../m"'), "the FMU has the model identifier '../m'"),
        (('causality="output"', 'causality="local"'), "the FMU has no real output"),
        (('name="u"', 'name="body_x_1"'), "variables 'body_x_1' and 'body.x[1]' of the FMU would both be 'body_x_1'"),
        (('name="u"', 'name="not"'), "variables 'not' and 'not' of the FMU would both be 'not_'"),
        (('valueReference="7"', 'valueReference="-"'), "variable 'body.x[1]' of the FMU has no value reference"),
        (('valueReference="7"', 'valueReference="4294967297"'), "no value reference from 0 to 4,294,967,295"),
        (("UTF-8", "none"), "modelDescription.xml cannot be read: unknown encoding: none"),
        (("</ModelVariables>", ""), "modelDescription.xml cannot be read: mismatched tag in line"),
        (
            ("<fmiModel", '<!DOCTYPE a [<!ENTITY b "c">]><fmiModel'),
            "modelDescription.xml cannot be read: it declares a document type",
        ),
        (("<ModelVariables>", "<a>" * 200), "elements lie more than 100 levels inside each other"),
    ],
)
def test_a_description_that_is_of_no_use(archive, change, message):
    path = archive({"modelDescription.xml": FMI2.replace(*change)})
    with pytest.raises(FmuError) as error:
        read_description(path)
    assert message in error.value.message


def link(name):
    entry = zipfile.ZipInfo(name)
    entry.external_attr = (stat.S_IFLNK | 0o777) << 16
    return entry


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("../outside", "which leads out of its folder"),
        ("a/../../outside", "which leads out of its folder"),
        ("/etc/outside", "which leads out of its folder"),
        ("C:/outside", "which leads out of its folder"),
        ("a\\..\\outside", "which leads out of its folder"),
        (link("resources/link"), "has a link 'resources/link'"),
    ],
)
def test_an_archive_that_writes_elsewhere_is_refused_before_it_is_unpacked(archive, tmp_path, entry, message):
    path = archive({"modelDescription.xml": FMI2, entry: "x"})
    for act in (read_description, lambda p: unpack(p, tmp_path / "out")):
        with pytest.raises(FmuError, match=message) as error:
            act(path)
        assert error.value.help_text == "no FMU needs that: ask who made it"
    assert not (tmp_path / "out").exists()


def test_an_archive_that_would_fill_the_disk_is_refused(archive, monkeypatch):
    path = archive({"modelDescription.xml": FMI2, "resources/zeros": b"\0" * 100_000})
    monkeypatch.setattr(fmu_archive, "MOST_BYTES", 50_000)
    with pytest.raises(FmuError, match="the archive is larger than") as error:
        read_description(path)
    assert error.value.facts == (f"it would unpack to 2 files of {100_000 + len(FMI2):,} bytes",)
    monkeypatch.setattr(fmu_archive, "MOST_BYTES", 1 << 30)
    monkeypatch.setattr(fmu_archive, "MOST_TEXT", 100)
    with pytest.raises(FmuError, match=r"modelDescription.xml has more than 100 bytes"):
        read_description(path)


def test_a_file_that_is_no_archive_or_a_broken_one(archive, tmp_path):
    path = archive({"modelDescription.xml": FMI2, "a.txt": "hello hello"})
    data = (tmp_path / "m.fmu").read_bytes()
    (tmp_path / "n.fmu").write_text("x", encoding="utf-8")
    with pytest.raises(FmuError, match="not a zip archive"):
        read_description(str(tmp_path / "n.fmu"))
    with pytest.raises(FmuError, match="there is no such file"):
        read_description(str(tmp_path / "o.fmu"))
    with pytest.raises(FmuError, match="not a regular file"):
        read_description(str(tmp_path))
    with pytest.raises(FmuError, match=r"no modelDescription.xml"):
        read_description(archive({"a": "b"}, "p.fmu"))
    (tmp_path / "m.fmu").write_bytes(data.replace(b"hello hello", b"hello jello"))
    with pytest.raises(FmuError, match="the archive cannot be unpacked: Bad CRC"):
        unpack(path, tmp_path / "out")
    (tmp_path / "m.fmu").write_bytes(data.replace(b'"u"', b'"v"'))
    with pytest.raises(FmuError, match=r"modelDescription.xml cannot be unpacked: Bad CRC"):
        read_description(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "m.fmu")
    with pytest.raises(FmuError, match="not a regular file"):
        read_description(str(tmp_path / "m.fmu"))

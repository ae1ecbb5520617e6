"""Descriptions of FMUs, and archives that are none, or that would write elsewhere or fill the disk."""

import os
import stat
import zipfile
from pathlib import Path

import pytest

from fuzzyctl import DiagnosticError, Loop, load, simulate
from fuzzyctl.testing import check_text
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


def read(path):
    """Return the plant of an FMU, and the diagnostics."""
    folder, name = os.path.split(path)
    blocks, found = check_text(f'plant p = fmu("{name}")\n', folder=Path(folder))
    return (blocks or (None,))[0], found


def refused(path):
    """Return the diagnostic of a file that is no FMU."""
    _, (found,) = read(path)
    assert (found.code, found.severity) == ("FZ218", "error")
    return found


def test_signals_and_binaries_are_those_of_the_fmu(archive):
    files = {"modelDescription.xml": FMI2, "binaries/linux64/m.so": b"", "binaries/win64/m.dll": b"", "sources/m.c": ""}
    plant, found = read(archive(files | {"binaries/win64/other.dll": b"", "binaries/darwin64/other.dylib": b""}))
    assert found == []
    assert [s.name for s in plant.inputs] == ["u"]
    assert [(s.name, s.label, s.unit) for s in plant.outputs] == [("body_x_1", "place", "m")]
    (facts,) = (d.facts for d in read(archive({k: v for k, v in files.items() if "linux" not in k}))[1])
    assert facts[0].startswith("it has binaries for: win64;")
    third, found = read(archive({"modelDescription.xml": FMI3}))
    assert [d.code for d in found] == ["FZ712"]
    assert [v.name for v in (*third.inputs, *third.outputs)] == ["u", "y"]


def test_many_variables_are_read_in_a_time_that_grows_with_their_number(archive):
    many = "".join(f'<ScalarVariable name="x{k}" valueReference="{k}"><Real/></ScalarVariable>' for k in range(60_000))
    path = archive({"modelDescription.xml": FMI2.replace("</ModelVariables>", many + "</ModelVariables>")})
    with at_most(4):
        assert [s.name for s in read(path)[0].outputs] == ["body_x_1"]


def test_names_become_those_of_rule_files(archive):
    names = {"der(x)": "der_x", "1st": "v1st", "σ*": "σ", "a b": "a_b", "*": "v", "and": "and_"}
    more = "".join(f'<Float64 name="{n}" valueReference="{k}" causality="output"/>' for k, n in enumerate(names, 9))
    plant, _ = read(archive({"modelDescription.xml": FMI3.replace("</ModelV", f"{more}</ModelV")}))
    assert [s.name for s in plant.outputs] == ["y", *names.values()]


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
    assert message in refused(path).message


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
def test_an_archive_that_writes_elsewhere_is_refused(archive, entry, message):
    path = archive({"modelDescription.xml": FMI2, entry: "x"})
    found = refused(path)
    assert message in found.message
    assert found.help == "no FMU needs that: ask who made it"


def test_an_archive_that_would_fill_the_disk_is_refused(archive, monkeypatch):
    path = archive({"modelDescription.xml": FMI2, "resources/zeros": b"\0" * 100_000})
    monkeypatch.setattr("fuzzyctl.simulation.fmu_archive.MOST_BYTES", 50_000)
    found = refused(path)
    assert "the archive is larger than" in found.message
    assert found.facts == (f"it would unpack to 2 files of {100_000 + len(FMI2):,} bytes",)
    monkeypatch.setattr("fuzzyctl.simulation.fmu_archive.MOST_BYTES", 1 << 30)
    monkeypatch.setattr("fuzzyctl.simulation.fmu_archive.MOST_TEXT", 100)
    assert "modelDescription.xml has more than 100 bytes" in refused(path).message


def test_a_file_that_is_no_archive_or_a_broken_one(archive, tmp_path):
    (tmp_path / "n.fmu").write_text("x", encoding="utf-8")
    (tmp_path / "q.fmu").mkdir()
    archive({"a": "b"}, "p.fmu")
    data = Path(archive({"modelDescription.xml": FMI2})).read_bytes()
    (tmp_path / "m.fmu").write_bytes(data.replace(b'"u"', b'"v"'))
    for name, words in {
        "n": "not a zip archive",
        "o": "there is no such file",
        "q": "not a regular file",
        "p": "no modelDescription.xml",
        "m": "modelDescription.xml cannot be unpacked: Bad CRC",
    }.items():
        assert words in refused(str(tmp_path / f"{name}.fmu")).message
    if hasattr(os, "mkfifo"):  # it is not waited for
        os.mkfifo(tmp_path / "r.fmu")
        assert "not a regular file" in refused(str(tmp_path / "r.fmu")).message


def test_a_file_of_the_archive_that_is_broken_ends_the_run(archive, tmp_path):
    pytest.importorskip("fmpy")
    files = {"modelDescription.xml": FMI2, "binaries/linux64/m.so": "", "a.txt": "hello hello"}
    data = Path(archive(files)).read_bytes()
    (tmp_path / "m.fmu").write_bytes(data.replace(b"hello hello", b"hello jello"))
    text = 'plant p = fmu("m.fmu")\nloop l\nblock p = p(0)\nrun 1 s step 0.1 s\n'
    (tmp_path / "l.fz").write_text(text, encoding="utf-8")
    with pytest.raises(DiagnosticError, match="the archive cannot be unpacked: Bad CRC"):
        simulate(load(tmp_path / "l.fz", block=Loop))

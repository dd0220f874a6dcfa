"""What a setup sheet says: figures of the program, sizes, the same bytes, a true verdict."""

import json
import re
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from beamcam.checks.bars import run
from beamcam.machine import load
from beamcam.model.part import Part
from beamcam.pictures import ReadProgram
from beamcam.pipeline import Posted, post, read_file
from beamcam.setup_sheet.content import SheetContent, SheetSources, content_of
from beamcam.setup_sheet.page import setup_page
from beamcam.setup_sheet.paper import setup_pdf
from beamcam.setup_sheet.playback import trace_data
from tests.conftest import SAMPLES
from tests.runs import call
from tests.unit.pictures.test_formats import contrast

DSTV = [str(SAMPLES / "dstv" / f"{name}.nc1") for name in ("channel", "tie", "channel")]


def posted(parts: tuple[Part, ...], name: str) -> tuple[Posted, ReadProgram]:
    machine = load(name)
    made = post(parts, machine)
    data = b"".join(made.pieces())
    bar = getattr(getattr(made.plan, "bar", None), "length", None)
    return made, ReadProgram(data, machine, f"JOB{machine.suffix}", machine.suffix, parts, bar)


@pytest.fixture(scope="module")
def annex() -> SheetContent:
    """The bar of three parts."""
    parts = tuple(part for path in DSTV for part in read_file(path).parts)
    made, program = posted(parts, "beamline-annex")
    return content_of(SheetSources(program, made.plan, made.remarks))


@pytest.fixture(scope="module")
def plate() -> SheetContent:
    """A gusset on a plasma table."""
    parts = read_file(str(SAMPLES / "dstv" / "gusset.nc1")).parts
    made, program = posted(parts, "plate-linuxcnc")
    return content_of(SheetSources(program, made.plan, made.remarks))


class Cells(HTMLParser):
    """The values of the cells of a page's tables."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.links += [str(given[k]) for k in ("src", "href") if given.get(k)]
        if tag == "tr":
            self.rows.append([])
        elif tag == "data" and self.rows and "value" in given:
            self.rows[-1].append(str(given["value"]))


def test_the_page_holds_each_operation_with_its_figures(annex: SheetContent) -> None:
    page = setup_page(annex)
    cells = Cells()
    cells.feed(page)
    profile = annex.program.parts[0].profile
    made = run(annex.program.text, annex.program.machine, profile).made
    for bore in made.bores:
        wanted = [f"{v:.6g}" for v in (bore.x, bore.y)]
        assert any(row[:2] == wanted for row in cells.rows), wanted
    holes = [hole for part in annex.program.parts for hole in part.holes]
    assert page.count("<td>through<") == len({b.line for b in made.bores})
    assert all(hole.depth is None for hole in holes)
    assert len(annex.operations) == len({op.line for op in made.order})
    assert sum(op.seconds for op in annex.operations) == pytest.approx(annex.seconds)
    assert all(op.seconds > 0.0 for op in annex.operations)
    assert annex.program.sha256 in page
    assert [link for link in cells.links if not link.startswith("#")] == ["data:,"]
    assert "http" not in page.replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")


@pytest.mark.parametrize("name", ["annex", "plate"])
def test_work_and_travel_are_all_of_the_time(name: str, request: pytest.FixtureRequest) -> None:
    content: SheetContent = request.getfixturevalue(name)
    *rows, travel, together = content.totals
    assert together.seconds == pytest.approx(content.seconds)
    assert together.work_s == pytest.approx(sum(row.work_s for row in rows))
    assert together.work_s + travel.seconds == pytest.approx(content.seconds)
    assert together.count == sum(row.count or 0 for row in rows) == len(content.operations)
    assert all(0.0 < row.work_s <= row.seconds + 1e-9 for row in rows)
    if name == "annex":
        assert [row.what for row in rows] == ["saw", "drill 18", "drill 14", "drill 22"]
        assert sum(row.seconds for row in rows) == pytest.approx(content.seconds)
        return
    trace = content.trace
    on = np.array([bool(s.process) for s in trace.states])[trace.state]
    ways = np.hypot(*np.diff(trace.positions[:, :2], axis=0).T)
    assert sum(row.length or 0.0 for row in rows) == pytest.approx(float(ways[on].sum()))
    assert travel.length == pytest.approx(float(ways[~on].sum()))
    page = setup_page(content)
    assert "Time by tool" in page


def test_the_page_s_header_tools_bar_and_ledger(annex: SheetContent) -> None:
    header = dict(annex.header)
    assert header["Mark"] == "C1, T1"
    assert header["Section"] == "UPN200"
    assert header["Quantity"] == "C1: 2 of 2, T1: 1 of 2"
    assert [s.what for s in annex.bar] == ["trim", "C1", "T1", "trim", "C1"]
    lengths = {s.what: s.end - s.start for s in annex.bar if s.what != "trim"}
    assert lengths == {"C1": pytest.approx(3000, abs=0.1), "T1": pytest.approx(320, abs=0.1)}
    assert {(t.where, t.tool) for t in annex.tools} == {
        ("left flange", "drill 14"), ("web", "drill 14"), ("web", "drill 18"), ("web", "drill 22"),
        ("right flange", "drill 14"),
    }  # fmt: skip
    assert all(t.station.isdigit() for t in annex.tools)
    assert annex.ledger == "39 read = 31 made + 8 merged"
    assert annex.verdict == "made"
    page = setup_page(annex)
    for text in (annex.ledger, "exactly these parts", "right flange", "plan-quantity"):
        assert text in page


def test_the_bar_of_three_parts_is_small_and_always_the_same(annex: SheetContent) -> None:
    page = setup_page(annex)
    assert len(page.encode()) < 500_000
    assert page == setup_page(annex)
    paper = setup_pdf(annex)
    assert paper.startswith(b"%PDF")
    assert paper == setup_pdf(annex)
    assert len(re.findall(rb"/Type /Page\b", paper)) >= 2


@pytest.mark.parametrize(("paper", "wide"), [("a4", 842), ("a3", 1191)])
def test_no_page_of_paper_has_a_heading_alone(paper: Any, wide: int) -> None:
    """A tall picture leaves room for the heading above it."""
    pdfium = pytest.importorskip("pypdfium2")
    parts = read_file(DSTV[1]).parts
    made, program = posted(parts, "beamline")
    pages = pdfium.PdfDocument(
        setup_pdf(content_of(SheetSources(program, made.plan, made.remarks)), paper)
    )
    for page in pages:
        assert round(page.get_size()[0]) == wide
        assert len(page.get_textpage().get_text_range().split()) > 20


def test_a_drawing_of_20_000_segments_stays_below_5_mb() -> None:
    blocks = ["%", "G21 G17 G90 G91.1 G40 G94", "G64 P0.01"]
    for path in range(100):
        y = 10.0 + 14 * path
        blocks += [f"G0 X10 Y{y:.4f}", "M3 S1", "G4 P0.5", "F2300"]
        blocks += [f"G1 X{10 + 7.013 * k:.4f} Y{y + 3.337 * (k % 2):.4f}" for k in range(1, 201)]
        blocks.append("M5")
    text = "\n".join([*blocks, "G0 X0 Y0", "M2", "%", ""])
    program = ReadProgram(text.encode(), load("plate-linuxcnc"), "JOB.ngc")
    content = content_of(SheetSources(program))
    assert len(content.operations) == 100
    assert len(content.trace.line) > 20_000
    page = setup_page(content)
    assert 1_000_000 < len(page.encode()) < 5_000_000


def test_the_trace_of_a_page_can_be_read_by_anyone(annex: SheetContent) -> None:
    """Unpacked here as the comment says, it is the trace."""
    data = trace_data(annex.trace)
    total = sum(data["t"]) / 1e6
    assert total == pytest.approx(annex.trace.duration_s, abs=1e-5)
    for k, column in enumerate(data["p"]):
        steps: list[int] = []
        for step in column:
            steps += [step[0]] * step[1] if isinstance(step, list) else [step]
        assert len(steps) == len(annex.trace.line)
        end = (data["start"][k] + sum(steps)) / 1000
        assert end == pytest.approx(annex.trace.positions[-1, k], abs=5.1e-4)
    assert sum(data["l"]) == annex.trace.line[-1]
    assert sum(count for _, count in data["o"]) == len(annex.trace.line)


def report(*words: str, code: int = 0) -> str:
    """What the command says."""
    done = call("report", *words)
    assert done.exit_code == code, done.output
    return done.output


def test_a_wrong_program_has_a_sheet_that_says_so(tmp_path: Path) -> None:
    job, page = tmp_path / "job.gcode", tmp_path / "job.html"
    assert call("post", DSTV[0], "-o", job).exit_code == 0
    report(str(job), DSTV[0], "-o", str(page))
    assert "exactly these parts" in page.read_text()
    job.write_text(job.read_text().replace("X3698.56", "X3598.56"))
    report(str(job), DSTV[0], "-o", str(page), code=1)
    text = page.read_text()
    assert 'class="verdict wrong"' in text
    assert "NOT RIGHT" in text
    assert "verify-" in text
    report(str(job), "-o", str(page))
    assert 'class="verdict alone"' in page.read_text()


def test_manual_work_is_listed(tmp_path: Path) -> None:
    page = tmp_path / "slot.html"
    words = ("--machine", "beamline", "--allow-skips", "slot")
    report(str(SAMPLES / "bad" / "slot.nc1"), *words, "-o", str(page))
    text = page.read_text()
    hand = text[text.index("Manual work") :].split("</ul>")[0]
    assert "slot" in hand


def test_marks_of_manual_work_are_listed_with_their_place(tmp_path: Path) -> None:
    source, page = tmp_path / "t.nc1", tmp_path / "t.html"
    text = Path(DSTV[0]).read_text()
    source.write_text(text.replace("EN\n", "SI\n  v    500.00u    100.00   0.00  10r M1-A\nEN\n"))
    report(str(source), "-o", str(page))
    hand = page.read_text().partition("Manual work")[2].partition("</section>")[0]
    assert "text M1-A" in hand
    assert "but for what is left for manual work" in page.read_text()
    assert 'value="500"' in hand
    report(str(source), "-o", str(tmp_path / "t.pdf"))


def test_a_run_that_strikes_is_warned_of_on_the_sheet(tmp_path: Path) -> None:
    job, page = tmp_path / "job.gcode", tmp_path / "job.html"
    assert call("post", DSTV[0], "-o", job).exit_code == 0
    report(str(job), "-o", str(page))
    assert "simulate-" not in page.read_text()
    job.write_text(job.read_text().replace("Y17.706", "Y400"))
    report(str(job), "-o", str(page))
    warnings = page.read_text().partition("Warnings and remarks")[2].partition("</section>")[0]
    assert "simulate-collision" in warnings
    assert "left spindle and right spindle" in warnings


def test_odd_names_cannot_break_the_page() -> None:
    part = read_file(DSTV[0]).parts[0]
    part = replace(part, mark="</script><b>\u2028", grade="<i>")
    made, program = posted((part,), "beamline")
    page = setup_page(content_of(SheetSources(program, made.plan, made.remarks)))
    assert "</script><b>" not in page
    assert "<i>" not in page
    for block in re.findall(
        r'<script type="application/json"[^>]*>(.*?)</script>', page, re.DOTALL
    ):
        json.loads(block)


@pytest.mark.parametrize("suffix", [".html", ".pdf"])
def test_inches_and_both_formats(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"sheet{suffix}"
    report(str(SAMPLES / "dstv" / "gusset.nc1"), "--unit", "inch", "-o", str(out))
    assert out.stat().st_size > 3000
    if suffix == ".html":
        assert 'data-unit="inch"' in out.read_text()


def test_another_suffix_is_wrong_usage(tmp_path: Path) -> None:
    said = report(DSTV[0], "-o", str(tmp_path / "x.docx"), code=2)
    assert "expected a name in .html, .pdf, or -" in " ".join(said.split())
    assert not (tmp_path / "x.docx").exists()


@pytest.mark.parametrize("path", ["setup_sheet/static/page.css", "reports/static/run.css"])
def test_texts_of_the_pages_can_be_told_from_their_ground(path: str) -> None:
    """4.5 to 1, as WCAG asks of texts, in the light and in the dark."""
    text = (SAMPLES.parent / "beamcam" / path).read_text()
    for block in re.findall(r":root \{(.*?)\}", text, re.DOTALL):
        colours = dict(re.findall(r"--(\w+): (#[0-9a-f]{3,6})", block))
        full = {k: v if len(v) == 7 else "#" + "".join(2 * c for c in v[1:])
                for k, v in colours.items()}  # fmt: skip
        for ink in ("ink", "soft", "good", "bad", "warn", "tool"):
            for ground in ("paper", "ground"):
                assert contrast(full[ink], full[ground]) >= 4.5, (path, ink, ground)


def test_a_sheet_is_the_same_in_each_folder(tmp_path: Path) -> None:
    pages = []
    for folder in (tmp_path / "a", tmp_path / "b" / "c"):
        folder.mkdir(parents=True)
        source = folder / "tie.nc1"
        source.write_bytes(Path(DSTV[1]).read_bytes())
        for suffix in (".html", ".pdf"):
            report(str(source), "-o", str(folder / f"tie{suffix}"))
        pages.append([(folder / f"tie{suffix}").read_bytes() for suffix in (".html", ".pdf")])
    assert pages[0] == pages[1]
    assert b"plan-quantity" in pages[0][0]


def test_the_hash_of_a_sheet_is_that_of_the_posted_file(tmp_path: Path) -> None:
    job, page = tmp_path / "job.ngc", tmp_path / "job.html"
    sample = str(SAMPLES / "dstv" / "gusset.nc1")
    assert call("post", sample, "-o", job).exit_code == 0
    report(sample, "--machine", "plate-linuxcnc", "-o", str(page))
    assert f'data-sha256="{sha256(job.read_bytes()).hexdigest()}"' in page.read_text()

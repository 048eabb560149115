"""Every page in a browser: nothing fetched, nothing complained of, every figure drawn, readable in light and dark."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from mjfriction.diagnose.diagnosis import diagnose_log
from mjfriction.identify.comparison import compare_robots
from mjfriction.identify.identification import identify_log
from mjfriction.record.readers import read_log
from mjfriction.report.comparison import write_comparison
from mjfriction.report.identified import make_identified_report
from mjfriction.report.reproduced import write_reproduced
from mjfriction.report.write import save_diagnosis, write_identified
from mjfriction.robot.files import read_robot
from tests.deep import deep
from tests.hidden.machine import Machine, write_case
from tests.reproduce.test_report import made_up

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
LEAST_CONTRAST = 4.5  # WCAG 2.1, level AA, for text of ordinary size
PROBE = """
<script>
const complaints = [];
window.addEventListener("error", event => complaints.push(String(event.message)));
const complain = console.error;
console.error = (...words) => { complaints.push(words.join(" ")); complain(...words); };
const numbers = colour => colour.match(/[\\d.]+/g).map(Number);
const light = ([r, g, b]) => [r, g, b].map(c => c / 255)
  .map(c => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
  .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
function behind(element) {
  for (let one = element; one; one = one.parentElement) {
    const colour = numbers(getComputedStyle(one).backgroundColor);
    if (colour.length < 4 || colour[3] > 0) return colour;
  }
  return [255, 255, 255];
}
function contrasts() {
  const out = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const parent = walker.currentNode.parentElement;
    if (!walker.currentNode.textContent.trim() || parent.closest("script, style, svg, .modebar-container")) continue;
    const [a, b] = [light(numbers(getComputedStyle(parent).color)), light(behind(parent))].sort((x, y) => y - x);
    out.push([(a + 0.05) / (b + 0.05), parent.tagName, walker.currentNode.textContent.trim().slice(0, 40)]);
  }
  return out.sort((one, other) => one[0] - other[0])[0];
}
window.addEventListener("load", () => setTimeout(() => {
  const told = document.createElement("pre");
  told.id = "probe";
  told.textContent = JSON.stringify({
    complaints,
    dark: matchMedia("(prefers-color-scheme: dark)").matches,
    fetched: performance.getEntriesByType("resource").map(entry => entry.name),
    figures: [...document.querySelectorAll(".plotly-graph-div")].map(div => div.id),
    drawn: [...document.querySelectorAll(".plotly-graph-div")].filter(div => div.querySelector("svg.main-svg"))
      .map(div => div.id),
    faintest: contrasts(),
    wider: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    beyond: [...document.querySelectorAll(".scroll")]
      .filter(box => box.scrollWidth > box.clientWidth && box.tabIndex < 0).length,
  });
  document.body.append(told);
}, 1500));
</script>"""

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on the path")


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("page")
    log, robot = write_case(folder, Machine(hidden={2: lambda i: 2.0 * abs(i.v)}), seed=2, seconds=20.0)
    stated = read_robot(robot)
    diagnosis = diagnose_log(read_log(log), stated)
    identification = identify_log(read_log(log), stated, law="coulomb_viscous", links=False)
    made = {name: folder / name for name in ("diagnosed", "identified", "compared", "reproduced")}
    for place in made.values():
        place.mkdir()
    save_diagnosis(diagnosis, made["diagnosed"])
    write_identified(identification, make_identified_report(identification), made["identified"])
    write_comparison(compare_robots(read_log(log), [("a", stated), ("b", diagnosis.robot)]), made["compared"])
    write_reproduced([made_up()], made["reproduced"])
    for place in made.values():
        whole = (place / "report.html").read_text(encoding="utf-8")
        (place / "probed.html").write_text(whole.replace("<head>", f"<head>{PROBE}", 1), encoding="utf-8")
    return {name: place / "probed.html" for name, place in made.items()}


def seen(page: Path, *, dark: bool, width: int) -> dict:
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=8000"]
    command += [f"--blink-settings=preferredColorScheme={0 if dark else 1}", f"--window-size={width},1200"]
    done = subprocess.run([*command, "--dump-dom", page.as_uri()], capture_output=True, text=True, check=True)
    (told,) = re.findall(r'<pre id="probe">(.*?)</pre>', done.stdout, re.DOTALL)
    return json.loads(html.unescape(told))


JOINTS = range(6)
FIGURES = {
    "diagnosed": ["errors", "finding-0", "course-0", "driven-0"],
    "identified": ["errors", *(f"law-{k}" for k in JOINTS), "course-0"],
    "compared": ["errors", *(f"course-{k}" for k in JOINTS)],
    "reproduced": ["table-0"],
}


@pytest.mark.parametrize(("dark", "width"), [(False, 1200), (True, 500)], ids=["light, desk", "dark, phone"])
@pytest.mark.parametrize("name", ["diagnosed", *(deep(n) for n in FIGURES if n != "diagnosed")])
def test_the_page_in_a_browser(pages: dict[str, Path], name: str, dark: bool, width: int) -> None:
    told = seen(pages[name], dark=dark, width=width)
    assert told["dark"] is dark
    assert told["complaints"] == []
    assert told["fetched"] == []
    assert told["figures"] == FIGURES[name]
    assert told["drawn"] == told["figures"]
    assert told["faintest"][0] > LEAST_CONTRAST, told["faintest"]
    assert told["wider"] <= 0, "the page itself scrolls sideways"
    assert told["beyond"] == 0, "a table that scrolls is out of the keyboard's reach"

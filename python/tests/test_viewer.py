"""The page of `tactus view` in headless Chromium: every control works, without foreign requests or logged errors."""

import os
import shutil
import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest

import tactus

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")

NAMES = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"]
BROWSER = os.environ.get("TACTUS_BROWSER") or next(filter(None, map(shutil.which, NAMES)), None)
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium on the path; TACTUS_BROWSER names one")

FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
DESKTOP, PHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 844}
CONTROLS = "button, input, select, summary, canvas"
OVERLAPS = """() => {
    const groups = [...document.querySelectorAll("svg, .ticks, #labels")].map((of) => [...of.querySelectorAll("text, span")]);
    const boxes = (group) => group.map((label) => [label.textContent, label.getBoundingClientRect()]).filter(([t]) => t.trim());
    const meet = ([, a], [, b]) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
    return groups.map(boxes).flatMap((all) => all.flatMap((a, i) => all.slice(i + 1).filter((b) => meet(a, b)).map((b) => [a[0], b[0]])));
}"""


@pytest.fixture(scope="module")
def run(small, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    tactus.run(small, grasps=[0, 1, 2], out=folder / "ball")
    return folder / "ball"


@pytest.fixture(scope="module")
def judged(data_set, trained):
    """Returns a data set and a network trained on it."""
    return data_set.folder, trained.folder


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=BROWSER, args=FLAGS)
        yield started
        started.close()


@contextmanager
def served(folder, model=None):
    """Serves the viewer and yields its address; Ctrl-C ends it."""
    code = "import sys, tactus; tactus.view(sys.argv[1], model=sys.argv[2] or None, browser=False)"
    command = [sys.executable, "-c", code, str(folder), str(model or "")]
    viewer = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield viewer.stdout.readline().strip()
    finally:
        viewer.send_signal(signal.SIGINT)
        _, said = viewer.communicate(timeout=60)
    assert viewer.returncode == 0, said


@contextmanager
def opened(browser, folder, model=None, size=DESKTOP, **more):
    """Opens the page and asserts at the end that there were no errors, warnings or requests elsewhere."""
    with served(folder, model) as address:
        page = browser.new_page(viewport=size, **more)
        wrong = []
        page.on("console", lambda said: wrong.append(said.text) if said.type in ("error", "warning") else None)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda asked: None if asked.url.startswith((address, "data:")) else wrong.append(asked.url))
        page.goto(address)
        page.wait_for_selector("body[data-ready]")
        page.wait_for_selector("#live.goes")
        try:
            yield page
            assert page.evaluate("document.body.dataset.errors") is None
        finally:
            page.close()
        # Chromium warns about slow read-back of software rendering.
        assert [text for text in wrong if "GPU stall" not in text] == []


def picture(page):
    """Returns a picture of the canvas at a fixed position and size: lines above it may shift it by part of a pixel."""
    alone = "position: fixed !important; inset: 0 auto auto 0; width: 640px !important; height: 400px !important; background: white; z-index: 9"
    fixed = page.add_style_tag(content=f"#canvas {{ {alone} }}")
    page.wait_for_function("() => document.getElementById('canvas').clientWidth === 640")
    page.wait_for_timeout(300)
    shot = page.locator("#canvas").screenshot()
    fixed.evaluate("(style) => style.remove()")
    return shot


class Driven:
    """Operates controls and records those of the page that have not been operated."""

    def __init__(self, page):
        self.page = page
        page.evaluate(f"document.querySelectorAll('{CONTROLS}').forEach((c, i) => c.dataset.control = i)")
        self.left = set(page.locator(CONTROLS).evaluate_all("all => all.map((c) => c.dataset.control)"))

    def changes(self, selector, act, look=picture):
        """Asserts that `act` on the control at `selector` changes the result of `look`."""
        control = self.page.locator(selector).first
        before = look(self.page)
        act(control)
        self.page.wait_for_function("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        assert look(self.page) != before, selector
        self.left.discard(control.get_attribute("data-control"))

    def rest(self):
        return [self.page.locator(f'[data-control="{i}"]').evaluate("c => c.outerHTML.slice(0, 90)") for i in self.left]


def slide(value):
    return lambda control: control.evaluate(f"c => {{ c.value = {value}; c.dispatchEvent(new Event('input')); }}")


def press(key):
    return lambda control: control.press(key)


def drag(control):
    box, mouse = control.bounding_box(), control.page.mouse
    mouse.move(box["x"] + 200, box["y"] + 100)
    mouse.down()
    mouse.move(box["x"] + 260, box["y"] + 130)
    mouse.up()


def wheel(control):
    control.hover()
    control.page.mouse.wheel(0, -240)


def pads(driven):
    """Operates the controls of every page with pads."""
    toggle = lambda control: control.click(force=True)  # noqa: E731
    driven.changes('input[name="quantity"][value="stress"]', toggle)
    driven.changes('input[name="quantity"][value="contact_force"]', toggle)
    driven.changes('input[name="quantity"][value="displacement"]', toggle)
    driven.changes("#frame", slide(0))
    driven.changes("#gain", slide(8))
    driven.changes("#own", toggle)
    driven.changes("#mesh", toggle)
    driven.changes("#object", toggle)
    for act in (drag, wheel, press("ArrowLeft"), press("ArrowRight"), press("ArrowUp"), press("ArrowDown")):
        driven.changes("#canvas", act)
    for act in (press("+"), press("-"), press("="), press("0")):
        driven.changes("#canvas", act)
    driven.changes("#canvas", drag)
    driven.changes("#canvas", lambda control: control.dblclick())
    driven.changes("#open", slide(0.5))
    driven.changes('input[name="layout"][value="1"]', lambda c: (toggle(c), c.page.wait_for_timeout(700)))
    driven.changes('input[name="layout"][value="0"]', lambda c: (toggle(c), c.page.wait_for_timeout(700)))
    shown = lambda page: page.locator("#at").text_content()  # noqa: E731
    driven.changes("#play", lambda c: (c.click(), c.page.wait_for_timeout(400)), shown)
    driven.changes("#frame", slide(0), shown)
    driven.changes("#canvas", lambda c: (c.press(" "), c.page.wait_for_timeout(400)), shown)
    driven.changes("#course svg", lambda c: c.click(position={"x": 60, "y": 60}), shown)
    driven.page.locator("#canvas").press("0")
    tip = lambda page: page.locator("#tip").get_attribute("hidden")  # noqa: E731
    driven.page.mouse.move(0, 0)
    driven.changes("#canvas", over_a_pad, tip)


def over_a_pad(control):
    box = control.bounding_box()
    for at in range(400):
        control.page.mouse.move(box["x"] + box["width"] * (at % 20) / 20, box["y"] + box["height"] * (at // 20) / 20)
        if control.page.locator("#tip").get_attribute("hidden") is None:
            return


def test_every_control_of_a_run_does_what_it_says(browser, run):
    with opened(browser, run) as page:
        driven = Driven(page)
        assert page.locator("#grasp option").count() == 3
        assert "cores" in page.locator("#origins").text_content(), "date, command and machine"
        driven.changes("#grasp", lambda control: control.select_option("1"))
        course = lambda page: page.locator("#grasp").input_value()  # noqa: E731
        driven.changes("#newest", lambda control: control.check(), course)
        pads(driven)
        alone = {"prediction", "difference", "all", "truth"}
        assert {page.locator(f'input[name="show"][value="{v}"]').is_disabled() for v in alone - {"truth"}} == {True}
        kept = [control for control in driven.rest() if 'name="show"' not in control]
        assert kept == [], "controls that no test drives"


def test_every_control_of_a_judged_network_does_what_it_says(browser, judged):
    data, model = judged
    with opened(browser, data, model) as page:
        driven = Driven(page)
        click = lambda control: control.click(force=True)  # noqa: E731
        for show in ("prediction", "difference", "all", "truth"):
            driven.changes(f'input[name="show"][value="{show}"]', click)
        pads(driven)
        for i in range(page.locator("[data-chart]").count()):
            lines = lambda page, i=i: page.locator("[data-chart]").nth(i).inner_html()  # noqa: E731
            for option in ("1", "2", "3", "0"):
                driven.changes(f'[data-chart="{i}"] select', lambda c, option=option: c.select_option(option), lines)
        for i in range(page.locator("summary").count()):
            fold = lambda page, i=i: page.locator("details").nth(i).get_attribute("open")  # noqa: E731
            driven.changes(f":nth-match(summary, {i + 1})", lambda c: c.click(), fold)
        if page.locator("#grasp option").count() > 1:
            driven.changes("#grasp", lambda c: c.select_option("0" if c.input_value() != "0" else "1"))
        rest = [control for control in driven.rest() if 'id="newest"' not in control and 'id="grasp"' not in control]
        assert rest == [], "controls that no test drives"


def test_a_training_shows_losses_that_grow(browser, judged):
    model = judged[1]
    table = (model / "curves.csv").read_text().splitlines()
    with opened(browser, model) as page:
        assert page.locator("[data-chart] circle").count() == 2 * (len(table) - 1)
        page.locator("[data-chart] select").select_option("1")
        assert page.locator("[data-chart] circle").count() == len(table) - 1, "learning rate"
        more = f"{len(table)},0.5,0.6,0.001"
        (model / "curves.csv").write_text("\n".join([*table, more]) + "\n")
        page.wait_for_function(f"() => document.querySelectorAll('[data-chart] circle').length === {len(table)}")
        assert page.locator("[data-chart] select").input_value() == "1", "the choice stays"
    (model / "curves.csv").write_text("\n".join(table) + "\n")


def test_a_run_shows_its_grasps_as_they_finish_and_the_view_stays(browser, small, tmp_path):
    folder = tmp_path / "run"
    tactus.run(small, grasps=[0, 1], out=folder)
    with opened(browser, folder) as page:
        page.locator("#grasp").select_option("0")
        page.locator('input[name="quantity"][value="stress"]').click(force=True)
        slide(1)(page.locator("#frame"))
        page.locator("#canvas").press("ArrowLeft")
        page.evaluate("window.kept = document.getElementById('canvas')")
        before = picture(page)
        again = "import sys, tactus; tactus.command('run', *sys.argv[1:])"
        arguments = [small.path, "-o", folder, "--overwrite", "--grasp=0", "--grasp=3", "--no-pictures"]
        subprocess.run([sys.executable, "-c", again, *map(str, arguments)], check=True)
        page.wait_for_function("() => [...document.querySelectorAll('#grasp option')].some((o) => o.textContent.includes('grasp 3'))")
        assert page.locator("#grasp option:checked").text_content().endswith("grasp 0")
        assert page.evaluate("window.kept === document.getElementById('canvas')"), "the same canvas"
        assert page.locator("#frame").input_value() == "1"
        assert picture(page) == before, "camera, grasp, frame and colours stay"


@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
@pytest.mark.parametrize("what", ["run", "data", "training"])
def test_nothing_overlaps_or_leaves_the_screen(browser, run, judged, what, size):
    folder, model = {"run": (run, None), "data": judged, "training": (judged[1], None)}[what]
    with opened(browser, folder, model, size, device_scale_factor=1) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
        for show in ["truth", "all"] if what == "data" else [None]:
            if show:
                page.locator(f'input[name="show"][value="{show}"]').click(force=True)
            assert page.evaluate(OVERLAPS) == []
        if what != "training":
            wide = page.locator("#canvas").bounding_box()
            for name in page.locator("#labels span:not(.pane)").all():
                box = name.bounding_box()
                inside = wide["x"] <= box["x"] and box["x"] + box["width"] <= wide["x"] + wide["width"]
                assert inside, f"{name.text_content()} is in the picture"

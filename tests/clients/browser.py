"""browser.py - headless Chromium on a page of a daemon, and what tests ask of it.

    with Browser(daemon) as page:
        page.click("#new-job")
        page.until(lambda: page.text("#job-line").startswith("done"))

Where there is no Chromium, driver or selenium every test is skipped, on import.
"""
import atexit
import functools
import shutil
import tempfile
import time

import tap

try:
    from OpenImageIO import ImageInput, ImageSpec
except ImportError:
    tap.skip_all("no python3-openimageio")

try:
    from selenium import webdriver
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.keys import Keys
except ImportError:
    tap.skip_all("no python3-selenium")

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if not CHROMIUM or not DRIVER:
    tap.skip_all("no chromium with its driver")

PATIENCE = 60  # seconds until a condition that must come counts as missing

# What the page does that the policy of its files forbids; console errors are kept by the driver.
WATCH = """
window.violations = [];
document.addEventListener("securitypolicyviolation", (event) =>
    window.violations.push(`${event.violatedDirective} ${event.blockedURI} ${event.sourceFile}`));
"""

NO_WEBGL = """
const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
    return kind === "webgl2" ? null : get.call(this, kind, ...rest);
};
"""

# A drop of files as the file manager of a desktop makes one.
DROP = """
const [files] = arguments, transfer = new DataTransfer();
for (const [name, bytes] of files) transfer.items.add(new File([new Uint8Array(bytes)], name));
const fire = (type) => document.body.dispatchEvent(new DragEvent(type,
    {bubbles: true, cancelable: true, dataTransfer: transfer}));
fire("dragenter");
fire("dragover");
window.overlay = !document.getElementById("drop").hidden;
fire("drop");
"""


SIZE = (1440, 1043)


def options():
    o = webdriver.ChromeOptions()
    o.binary_location = CHROMIUM
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--mute-audio",
                     "--force-color-profile=srgb", "--force-device-scale-factor=1",
                     "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                     "--disable-background-networking", "--no-first-run",
                     f"--window-size={SIZE[0]},{SIZE[1]}"):
        o.add_argument(argument)
    o.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return o


def decode(png):
    """uint8 [height][width][channels]"""
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        file.write(png)
        file.flush()
        as_it_is = ImageSpec()
        as_it_is.attribute("oiio:UnassociatedAlpha", 1)
        image = ImageInput.open(file.name, as_it_is)
        pixels = image.read_image("uint8")
        image.close()
    return pixels


@functools.cache
def start():
    """One browser for all tests of a program: it takes longer to start than most of them."""
    driver = webdriver.Chrome(options=options(), service=Service(DRIVER))
    atexit.register(driver.quit)
    driver.set_script_timeout(PATIENCE)
    driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
    return driver


class Browser:
    resolution = (160, 120)  # of the jobs that are looked at

    def __init__(self, daemon, webgl=True):
        self.daemon, self.webgl = daemon, webgl

    def __enter__(self):
        self.driver = start()
        self.driver.get_log("browser")
        self.script = self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument",
                                                  {"source": "" if self.webgl else NO_WEBGL})
        self.driver.get(self.daemon.url)
        return self

    def __exit__(self, *error):
        complaints = self.complaints()
        self.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", self.script)
        self.driver.get("about:blank")  # lets go of the daemon
        if not any(error):
            assert complaints == [], complaints

    # What the browser says against the page: violated policy, console errors that tests do not
    # provoke. An answer of 4xx is one of its own making.
    def complaints(self):
        logged = [entry["message"] for entry in self.driver.get_log("browser")
                  if entry["level"] in ("SEVERE", "WARNING") and "the server responded with a status"
                  not in entry["message"] and "GPU stall" not in entry["message"]]
        return logged + self.run("return window.violations")

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def until(self, condition, patience=PATIENCE):
        end = time.monotonic() + patience
        while not (value := condition()):
            assert time.monotonic() < end, f"never: {condition.__code__.co_consts}, {self.state()}"
            time.sleep(0.05)
        return value

    def state(self):
        return self.run("return document.body.innerText")[-3000:]

    def find(self, css):
        return self.driver.find_element(By.CSS_SELECTOR, css)

    def all(self, css):
        return self.driver.find_elements(By.CSS_SELECTOR, css)

    def click(self, css):
        self.find(css).click()

    def text(self, css):
        return self.run("return document.querySelector(arguments[0])?.textContent ?? ''", css)

    def texts(self, css):
        return self.run("return [...document.querySelectorAll(arguments[0])].map((e) => e.textContent)",
                        css)

    def set(self, css, value):
        """A value as if it were typed, for controls that are no text."""
        self.run("""const e = document.querySelector(arguments[0]);
            e.value = arguments[1];
            for (const type of ["input", "change"]) e.dispatchEvent(new Event(type, {bubbles: true}));""",
                 css, value)

    def press(self, *keys):
        chain = ActionChains(self.driver)
        for key in keys:
            chain.send_keys(key)
        chain.perform()

    def focused(self):
        return self.run("const e = document.activeElement; return e.id || e.textContent.trim()")

    def drop(self, files):
        """{name: bytes}"""
        self.run(DROP, [[name, list(content)] for name, content in files.items()])

    # The picture as it is on the screen, at actual pixels

    def actual(self):
        self.click("#zoom-text")
        self.until(lambda: self.text("#zoom-text") == "100 %")

    def drawn(self):
        """x, y of the picture's corner on the screen and the size of a pixel there, once it is drawn as
        the page now has it: it draws by the frame, and says where only then."""
        return self.driver.execute_async_script("""const done = arguments[arguments.length - 1];
            requestAnimationFrame(() => requestAnimationFrame(() => {
                const v = document.getElementById("viewport"), box = v.getBoundingClientRect();
                const [x, y, scale] = v.dataset.place.split(" ").map(Number);
                done([box.left + x, box.top + y, scale]);
            }));""")

    def place(self):
        """x, y of the picture's corner on the screen."""
        return self.drawn()[:2]

    def picture(self):
        """uint8 [height][width][3] of what the screen shows where the picture is."""
        (left, top), (width, height) = self.place(), self.resolution
        screen = decode(self.driver.get_screenshot_as_png())
        left, top = int(left), int(top)
        return screen[top:top + height, left:left + width, :3].astype(int)

    def at(self, x, y):
        """Moves the pointer over a pixel of the picture."""
        left, top = self.place()
        return self.pointer(left + x, top + y)

    def pointer(self, x, y):
        """Moves the pointer over a point of the page."""
        chain = ActionChains(self.driver)
        chain.w3c_actions.pointer_action.move_to_location(int(x), int(y))
        return chain

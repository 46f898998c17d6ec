# SPDX-License-Identifier: MIT
"""A page on disk in chromium, as the tests of pages open it: Debian's chromium, driven by Debian's Python."""
import json
import os
import tempfile
import unittest

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

ARGUMENTS = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--force-device-scale-factor=1")


class PageTest(unittest.TestCase):
    """Base of a page's tests. A class of tests makes its page in `make`, which returns the file's path, and sets WIDTH and FOLDER."""
    WIDTH = 1280
    FOLDER = ""  # where screenshots are left

    @classmethod
    def make(cls):
        raise NotImplementedError

    @classmethod
    def setUpClass(cls):
        cls.page = cls.make()
        cls.profile = tempfile.TemporaryDirectory()
        options = webdriver.ChromeOptions()
        for argument in ARGUMENTS + (f"--user-data-dir={cls.profile.name}",):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        cls.browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.profile.cleanup()

    def setUp(self):
        self.open(self.WIDTH, dark=False)

    def sized(self, width, height):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})

    def open(self, width, dark):
        """Opens the page anew and waits until it says that it is ready. The logs hold what came since."""
        self.sized(width, 900)
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
        self.browser.get_log("browser")
        self.browser.get_log("performance")
        self.browser.get("file://" + self.page)
        WebDriverWait(self.browser, 30).until(lambda b: b.execute_script("return document.body.dataset.ready") == "yes")

    def find(self, css):
        return self.browser.find_element(By.CSS_SELECTOR, css)

    def all(self, css):
        return self.browser.find_elements(By.CSS_SELECTOR, css)

    def script(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def shot(self, name):
        """Screenshot of the whole page, as wide as it is shown."""
        self.sized(self.script("return innerWidth"), self.script("return document.documentElement.scrollHeight"))
        self.browser.save_screenshot(os.path.join(self.FOLDER, name + ".png"))

    def asks_for_nothing(self):
        """Fails where the page wrote to the console or asked for anything but itself."""
        self.assertEqual(list(self.browser.get_log("browser")), [], "nothing on the console")
        asked = [json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance")]
        # The browser's own first tab (chrome://) may still be loading when this one opens.
        addresses = [a["params"]["request"]["url"] for a in asked if a["method"] == "Network.requestWillBeSent" and not a["params"]["documentURL"].startswith("chrome:")]
        self.assertIn("file://" + self.page, addresses, "the log of requests is on")
        self.assertEqual([u for u in addresses if not u.startswith(("file://" + self.page, "data:"))], [])

    def fits_sideways(self):
        wide, inside = self.script("return [document.documentElement.scrollWidth, innerWidth]")
        self.assertLessEqual(wide, inside, f"{inside} px: the page does not scroll sideways")

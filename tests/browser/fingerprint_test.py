#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The page of `plumb devices --fingerprint` as a reader meets it, in chromium: opened from disk, by mouse and by keyboard, narrow and wide, light and dark.

usage: fingerprint_test.py PLUMB FOLDER    screenshots are left in FOLDER
"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import WebDriverWait

PLUMB, FOLDER = (os.path.abspath(path) for path in sys.argv[1:3])


class FingerprintPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.page, report = os.path.join(FOLDER, "fingerprint.html"), os.path.join(FOLDER, "fingerprint.json")
        subprocess.run([PLUMB, "devices", "--fingerprint", "-o", cls.page, "--json=" + report], check=True, capture_output=True)
        with open(report, encoding="utf-8") as f:
            cls.report = json.load(f)
        cls.profile = tempfile.TemporaryDirectory()
        options = webdriver.ChromeOptions()
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--force-device-scale-factor=1", f"--user-data-dir={cls.profile.name}"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        cls.browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.profile.cleanup()

    def setUp(self):
        self.open(1280, dark=False)

    def open(self, width, dark):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
        self.browser.get_log("browser")
        self.browser.get_log("performance")
        self.browser.get("file://" + self.page)
        WebDriverWait(self.browser, 30).until(lambda b: b.execute_script("return document.body.dataset.ready") == "yes")

    def all(self, css):
        return self.browser.find_elements(By.CSS_SELECTOR, css)

    def script(self, text, *arguments):
        return self.browser.execute_script(text, *arguments)

    def test_it_asks_for_nothing(self):
        self.assertEqual(list(self.browser.get_log("browser")), [], "nothing on the console")
        asked = [json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance")]
        addresses = [a["params"]["request"]["url"] for a in asked if a["method"] == "Network.requestWillBeSent" and not a["params"]["documentURL"].startswith("chrome:")]
        self.assertIn("file://" + self.page, addresses, "the log of requests is on")
        self.assertEqual([u for u in addresses if not u.startswith(("file://" + self.page, "data:"))], [])

    def test_every_trait_is_there_with_its_verdict(self):
        rows = self.script("return [...document.querySelectorAll('.trait:not(.head)')].map(r => [r.querySelector('b').textContent, r.className.split(' ')[1]])")
        self.assertEqual(sorted(map(tuple, rows)), sorted((t["name"], t["verdict"]) for t in self.report["traits"]))
        facts = self.script("return document.getElementById('facts').textContent")
        self.assertIn(self.report["hash"], facts)
        self.assertIn(self.report["device"]["name"], self.script("return document.getElementById('title').textContent"))

    def test_a_cell_is_read_by_mouse_and_by_keyboard(self):
        cells = self.script("return document.querySelectorAll('#map button').length")
        self.assertEqual(cells, sum(len(t["decades"]) for t in self.report["traits"] if "decades" in t))
        first, second = self.all("#map button")[:2]
        first.click()
        said = self.script("return document.getElementById('cell').textContent")
        self.assertIn(first.get_attribute("title"), said)
        self.assertIn("first at x", said)
        self.script("arguments[0].focus()", second)
        self.assertIn(second.get_attribute("title"), self.script("return document.getElementById('cell').textContent"))

    def test_narrow_wide_and_dark(self):
        for width in (400, 1280):
            for dark in (False, True):
                self.open(width, dark)
                wide, inside = self.script("return [document.documentElement.scrollWidth, innerWidth]")
                self.assertLessEqual(wide, inside, f"{width} px: the page does not scroll sideways")
                # Words of a row neither leave the page nor stand on each other.
                beyond = self.script("""return [...document.querySelectorAll('.trait:not(.head) > *')].filter(e => {
                    const box = e.getBoundingClientRect(); return box.width > 0 && (box.right > innerWidth + 0.5 || e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).display !== 'inline'); })
                    .map(e => e.textContent)""")
                self.assertEqual(beyond, [], f"{width} px")
                over = self.script("""return [...document.querySelectorAll('.trait:not(.head)')].filter(row => {
                    const boxes = [...row.children].map(e => e.getBoundingClientRect()).filter(b => b.width > 0 && b.height > 0);
                    return boxes.some((a, i) => boxes.some((b, j) => i < j && Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1)); })
                    .map(row => row.textContent)""")
                self.assertEqual(over, [], f"{width} px")
                ground, ink = self.script("const s = getComputedStyle(document.body); return [s.backgroundColor, s.color].map(c => c.match(/\\d+/g).slice(0, 3).reduce((a, b) => a + +b, 0))")
                self.assertEqual(ground < ink, dark)
                self.browser.save_screenshot(os.path.join(FOLDER, f"fingerprint-{width}-{'dark' if dark else 'light'}.png"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)

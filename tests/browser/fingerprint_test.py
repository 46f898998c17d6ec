#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The page of `plumb devices --fingerprint` as a reader meets it, in chromium: opened from disk, by mouse and by keyboard, narrow and wide, light and dark.

usage: fingerprint_test.py PLUMB FOLDER    screenshots are left in FOLDER
"""
import json
import os
import subprocess
import sys
import unittest

from page import PageTest

PLUMB, FOLDER = (os.path.abspath(path) for path in sys.argv[1:3])


class FingerprintPage(PageTest):
    FOLDER = FOLDER

    @classmethod
    def make(cls):
        page, report = os.path.join(FOLDER, "fingerprint.html"), os.path.join(FOLDER, "fingerprint.json")
        subprocess.run([PLUMB, "devices", "--fingerprint", "-o", page, "--json=" + report], check=True, capture_output=True)
        with open(report, encoding="utf-8") as f:
            cls.report = json.load(f)
        return page

    def test_it_asks_for_nothing(self):
        self.asks_for_nothing()

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
                self.fits_sideways()
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

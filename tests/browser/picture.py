#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A picture of the top of a report, for README and docs. usage: picture.py REPORT.html OUT.png [HEIGHT]"""
import os
import sys
import tempfile

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import WebDriverWait

page, out = (os.path.abspath(path) for path in sys.argv[1:3])
height = int(sys.argv[3]) if len(sys.argv) > 3 else 1640
with tempfile.TemporaryDirectory() as profile:
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", f"--user-data-dir={profile}"):
        options.add_argument(argument)
    browser = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 1080, "height": height, "deviceScaleFactor": 1, "mobile": False})
    browser.get("file://" + page)
    WebDriverWait(browser, 30).until(lambda b: b.execute_script("return document.body.dataset.ready") == "yes")
    browser.save_screenshot(out)
    browser.quit()

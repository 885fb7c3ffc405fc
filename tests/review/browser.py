"""The headless browser in which the pages are tested."""
import shutil
import time

from selenium import webdriver
from selenium.common.exceptions import StaleElementReferenceException
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By

DRIVER = shutil.which("chromedriver")


def headless(width, height, profile):
    """It keeps what it writes in the folder `profile`, and the console's lines for get_log."""
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                     f"--window-size={width},{height}", f"--user-data-dir={profile}"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(options=options, service=Service(DRIVER))


class PageParts:
    """Of a test whose `browser` shows a page."""

    def part(self, name):
        return self.browser.find_element(By.ID, name)

    def text(self, name):
        return self.part(name).text

    def wait_until(self, condition, wait_s, what):
        """`what` is told of when it never holds."""
        def holds():
            try:
                return condition()
            except StaleElementReferenceException:  # the page replaced an element between two questions
                return False

        end = time.monotonic() + wait_s
        while not holds():
            self.assertLess(time.monotonic(), end, what() if callable(what) else what)
            time.sleep(0.08)

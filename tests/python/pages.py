"""Pages as a browser leaves them."""

import re
import subprocess
from pathlib import Path


def markup(address: str, folder: Path) -> tuple[str, str]:
    """A page's markup after its script ran, and what the browser logged."""
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--virtual-time-budget=3000", "--dump-dom"]
    done = subprocess.run([*command, f"--user-data-dir={folder}/profile", address], capture_output=True, text=True, timeout=120, check=False)
    return done.stdout, done.stderr


def drawn(address: str, folder: Path) -> tuple[str, str]:
    """What a page shows without its program, and what it complained about."""
    text, log = markup(address, folder)
    shown = re.sub(r"<script.*?</script>|<style.*?</style>", "", text, flags=re.S)
    return shown, "\n".join(line for line in log.splitlines() if "CONSOLE" in line)

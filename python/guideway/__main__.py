"""``python -m guideway``."""

import sys

from guideway.cli import main

sys.exit(main())

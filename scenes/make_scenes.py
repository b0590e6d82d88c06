#!/usr/bin/env python3
"""Writes every scene of this folder. Plain Python 3, no options, same bytes every time.

    python3 make_scenes.py              all scenes, beside this file
    python3 make_scenes.py bubbles oil  only these

Lengths are centimetres, y is up. Thicknesses are nanometres. The scenes are in make/: small.py, report.py, gallery.py.
"""

import sys

from make import gallery, report, small

SCENES = small.SCENES + report.SCENES + gallery.SCENES


def main():
    wanted = sys.argv[1:] or [scene.__name__ for scene in SCENES]
    unknown = set(wanted) - {scene.__name__ for scene in SCENES}
    if unknown:
        sys.exit("no such scene: " + ", ".join(sorted(unknown)))
    for scene in SCENES:
        if scene.__name__ in wanted:
            scene()
            print("wrote", scene.__name__)


main()

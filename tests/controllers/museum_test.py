"""Every exhibit of the museum runs, its cure better than its fault: museum_test.py CALTWIN"""

import json
import subprocess
import sys

told = json.loads(subprocess.run([sys.argv[1], "compare", "museum", "--json", "-"], check=True,
                                 stdout=subprocess.PIPE, text=True).stdout)
assert len(told["exhibits"]) >= 20
for one in told["exhibits"]:
    assert not one["not_run"], (one["fault"], one["not_run"])
    left, cured = one["as_published"]["after"], one["cured"]["after"]
    assert left is None or cured < 0.3 * left, one

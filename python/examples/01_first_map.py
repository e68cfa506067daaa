# SPDX-License-Identifier: Apache-2.0
"""Maps a folder of images, a video or a bag, then asks the map.

01_first_map.py SEQUENCE MAP.estancia WORDS
"""

import sys

import estancia

sequence, path, words = sys.argv[1:4]
home = estancia.map_sequence(sequence, path, progress=True)
for answer in home.ask(words).places[:3]:
    print(f"place {answer.node}: {answer.probability:.1%} {answer.matched}")
print("way there:", home.route(words, start=home.frames[0].node).nodes)
home.write_page("home.html")

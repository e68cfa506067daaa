# SPDX-License-Identifier: Apache-2.0
"""Which room is this? Learned from images whose rooms are known (rooms.csv beside them, or a folder a room).

05_name_rooms.py SEQUENCE IMAGE
"""

import sys

import estancia

features = estancia.describe_sequence(estancia.open_sequence(sys.argv[1]), "inception-v3")
rooms = estancia.train_room_classifier(features)
print(rooms.choice)
for room in rooms.predict_image(estancia.read_image(sys.argv[2]))[:3]:
    print(f"{room.room} {room.probability:.1%}")

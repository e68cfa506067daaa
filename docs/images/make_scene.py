# SPDX-License-Identifier: Apache-2.0
"""Made-up RGB-D data for the documentation's images: objects as distance fields, seen by a noisy depth camera.

    make_scene.py FOLDER

writes FOLDER/table (rgb/, depth/, camera-intrinsics.txt: a sequence), FOLDER/clutter.pcd and FOLDER/noisy.pcd (a view with the
noise of a Kinect, and with 10 mm), FOLDER/models/NAME.pcd (whole surfaces) and FOLDER/views/CATEGORY/INSTANCE/VIEW.pcd (single
views to learn from). Lengths are meters; y points down, z forward, as a camera sees.
"""
import pathlib
import sys

import numpy as np
from skimage import io

FX, WIDTH, HEIGHT = 525.0, 640, 480
rng = np.random.default_rng(1)


def cylinder(p, radius, height):  # upright, standing on y = 0
    d = np.stack([np.hypot(p[..., 0], p[..., 2]) - radius, np.abs(p[..., 1] + height / 2) - height / 2], -1)
    return np.minimum(d.max(-1), 0) + np.linalg.norm(np.maximum(d, 0), axis=-1)


def torus(p, center, ring, tube):  # in the plane of x and y
    q = p - center
    return np.hypot(np.hypot(q[..., 0], q[..., 1]) - ring, q[..., 2]) - tube


def capsule(p, a, b, radius):
    a, b = np.array(a), np.array(b)
    t = np.clip(((p - a) @ (b - a)) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - t[..., None] * (b - a), axis=-1) - radius


def box(p, size):
    d = np.abs(p + [0, size[1] / 2, 0]) - np.array(size) / 2
    return np.minimum(d.max(-1), 0) + np.linalg.norm(np.maximum(d, 0), axis=-1)


def mug(p, s):
    body = np.maximum(cylinder(p, .042 * s, .1 * s), -cylinder(p + [0, .008, 0], .037 * s, .12 * s))
    return np.minimum(body, np.maximum(torus(p, [.047 * s, -.05 * s, 0], .028 * s, .007), -cylinder(p, .038 * s, .2)))


def bowl(p, s):
    q = p + [0, .075 * s, 0]
    r = np.linalg.norm(q, axis=-1)
    shell = np.maximum(np.abs(r - .075 * s) - .004, -q[..., 1])
    return np.minimum(shell, cylinder(p, .03 * s, .006))


def bottle(p, s):
    neck = cylinder(p + [0, .15 * s, 0], .014 * s, .07 * s)
    shoulder = np.linalg.norm((p + [0, .145 * s, 0]) * [1, 1.1, 1], axis=-1) - .036 * s
    return np.minimum(np.minimum(cylinder(p, .036 * s, .15 * s), neck), shoulder)


def teapot(p, s):
    q = p + [0, .06 * s, 0]
    body = (np.linalg.norm(q * [1, 1.15, 1], axis=-1) - .07 * s) * .85
    lid = np.linalg.norm(p + [0, .13 * s, 0], axis=-1) - .014 * s
    spout = capsule(p, [-.06 * s, -.05 * s, 0], [-.12 * s, -.11 * s, 0], .012 * s)
    return np.minimum.reduce([body, lid, spout, torus(p, [.075 * s, -.065 * s, 0], .035 * s, .008)])


def carton(p, s):
    return box(p, (.09 * s, .19 * s, .06 * s))


def can(p, s):
    return cylinder(p, .034 * s, .115 * s)


def ball(p, s):
    return np.linalg.norm(p + [0, .05 * s, 0], axis=-1) - .05 * s


def book(p, s):
    return box(p, (.15 * s, .035 * s, .2 * s))


SHAPES = {f.__name__: f for f in (mug, bowl, bottle, teapot, carton, can, ball, book)}
COLORS = {"mug": (205, 70, 60), "bowl": (235, 200, 90), "bottle": (70, 130, 90), "teapot": (90, 120, 190),
          "carton": (225, 225, 230), "can": (190, 60, 70), "ball": (230, 140, 50), "book": (60, 90, 150), "": (150, 120, 95)}
CLUTTER = [("mug", -.2, .02, .9, 1), ("bowl", .02, -.1, 0, 1), ("bottle", -.06, .16, 0, 1), ("teapot", .2, .03, 2.6, 1),
           ("carton", .12, .25, .5, 1)]
TABLE = [("can", -.2, .05, 0, 1), ("bowl", .02, -.1, 0, 1.1), ("ball", -.06, .14, 0, 1), ("book", .23, .02, .6, 1),
         ("carton", .1, .24, .4, 1)]


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def field(p, objects, table):
    """Distance to the nearest of `objects` (name, x, z, angle, scale) and its number; the table is y = 0, number -1."""
    best = -p[..., 1] if table else np.full(p.shape[:-1], np.inf)
    which = np.full(p.shape[:-1], -1)
    for i, (name, x, z, angle, scale) in enumerate(objects):
        d = SHAPES[name]((p - [x, 0, z]) @ turned(angle), scale)
        which = np.where(d < best, i, which)
        best = np.minimum(best, d)
    return best, which


def look(objects, eye, target, table=True):
    """Marches a ray a pixel. Points [world], their numbers and normals, hits, and the camera's rotation (rows: x, y, z)."""
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross([0, 1, 0], z)
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z])
    u, v = np.meshgrid(np.arange(WIDTH) - (WIDTH - 1) / 2, np.arange(HEIGHT) - (HEIGHT - 1) / 2)
    rays = np.stack([u / FX, v / FX, np.ones_like(u)], -1) @ rotation
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    rays = rays.reshape(-1, 3)
    t, near = np.full(len(rays), .3), np.full(len(rays), np.inf)
    # Without a table only what is near the target can be hit.
    miss = np.linalg.norm(np.cross(rays, target - eye), axis=-1)
    open_ = np.flatnonzero(table | (miss < .2))
    for _ in range(160):
        d, _ = field(eye + t[open_, None] * rays[open_], objects, table)
        near[open_] = d
        t[open_] += .9 * d
        open_ = open_[(np.abs(d) > 2e-4) & (t[open_] < 3)]
        if not len(open_):
            break
    points, normals, which = eye + t[:, None] * rays, np.zeros_like(rays), np.full(len(rays), -1)
    hit = (np.abs(near) < 1e-3) & (t < 3)
    there, e = points[hit], 1e-4
    which[hit] = field(there, objects, table)[1]
    n = np.stack([field(there + e * a, objects, table)[0] - field(there - e * a, objects, table)[0] for a in np.eye(3)], -1)
    normals[hit] = n / np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-9)
    return points, which, normals, hit, rotation


def shade(objects, which, normals, points):
    albedo = np.array([COLORS[o[0]] for o in objects] + [COLORS[""]], float)[which]
    light = np.clip(normals @ (np.array([-.4, -.8, -.5]) / 1.02), 0, 1)
    grain = 1 + .06 * np.sin(points[:, :1] * 40 + 3 * np.sin(points[:, 2:] * 9)) * (which == -1)[:, None]
    return np.clip(albedo * grain * (.35 + .65 * light[:, None]), 0, 255).astype(np.uint8)


def write_pcd(path, points, colors):
    path.parent.mkdir(parents=True, exist_ok=True)
    rgb = (colors[:, 0].astype(np.uint32) << 16 | colors[:, 1].astype(np.uint32) << 8 | colors[:, 2]).view(np.float32)
    data = np.column_stack([points.astype(np.float32), rgb]).astype("<f4")
    head = ("VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
            f"WIDTH {len(data)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(data)}\nDATA binary\n")
    path.write_bytes(head.encode() + data.tobytes())


def photograph(objects, eye):
    """Color, depth [m] with a Kinect's noise, hits, and rays with z = 1, one a pixel."""
    points, which, normals, hit, rotation = look(objects, eye, np.array([0, -.04, .05]))
    color = np.where(hit[:, None], shade(objects, which, normals, points), 60).astype(np.uint8)
    seen = (points - eye) @ rotation.T
    return color, seen[:, 2] + rng.normal(0, .0012, len(seen)) * seen[:, 2] ** 2, hit, seen / seen[:, 2:]


def main(folder):
    for name in ("rgb", "depth"):
        (folder / "table" / name).mkdir(parents=True, exist_ok=True)
    (folder / "table/camera-intrinsics.txt").write_text(f"{FX} {FX} {(WIDTH - 1) / 2} {(HEIGHT - 1) / 2}\n")
    for frame in range(4):
        color, z, hit, _ = photograph(TABLE, np.array([-.08 + .04 * frame, -.45, -.75]))
        depth = np.where(hit, np.round(z * 1000), 0).astype(np.uint16)
        io.imsave(folder / f"table/rgb/{frame:04}.png", color.reshape(HEIGHT, WIDTH, 3), check_contrast=False)
        io.imsave(folder / f"table/depth/{frame:04}.png", depth.reshape(HEIGHT, WIDTH), check_contrast=False)
    color, z, hit, rays = photograph(CLUTTER, np.array([-.02, -.45, -.75]))
    cloud = (rays * z[:, None])[hit]
    write_pcd(folder / "clutter.pcd", cloud, color[hit])
    write_pcd(folder / "noisy.pcd", cloud + rng.normal(0, .01, cloud.shape), color[hit])
    for name in ("bottle", "teapot"):
        single = [(name, 0, 0, 0, 1)]
        whole = []
        for k in range(14):
            eye = np.array([.7 * np.cos(k), -.35 + .06 * (k % 7), .7 * np.sin(k)])
            points, which, normals, hit, _ = look(single, eye, np.array([0, -.06, 0]), table=False)
            pick = rng.permutation(np.flatnonzero(hit))[:2500]
            whole.append((points[pick], shade(single, which[pick], normals[pick], points[pick])))
        write_pcd(folder / f"models/{name}.pcd", *map(np.concatenate, zip(*whole)))
    for name in ("can", "bowl", "ball", "book", "carton"):
        for instance, scale in enumerate((.85, 1, 1.15)):
            for view in range(6):
                single = [(name, 0, 0, rng.uniform(0, 6.28), scale)]
                eye = np.array([0, -rng.uniform(.35, .6), -.75])
                points, which, normals, hit, rotation = look(single, eye, np.array([0, -.06, 0]), table=False)
                pick = np.flatnonzero(hit)[::2]
                cloud = (points[pick] - eye) @ rotation.T
                cloud *= 1 + rng.normal(0, .0009, (len(pick), 1))
                write_pcd(folder / f"views/{name}/{name}{instance}/{view}.pcd", cloud,
                          shade(single, which[pick], normals[pick], points[pick]))


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))

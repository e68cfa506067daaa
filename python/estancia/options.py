# SPDX-License-Identifier: Apache-2.0
"""Options: the keyword arguments of the package's functions. Each is declared once, in the library, which checks it.

Made by python/generate_options.py. A group inside is a dict:
``scene_filter={"method": "gng", "points": 5000}``.
"""

from __future__ import annotations

import os
from typing import Literal, TypedDict, Union

__all__ = [
    "SequenceOptions",
    "CheckOptions",
    "LabelerOptions",
    "LabelStreamOptions",
    "LabelFileOptions",
    "MapperThresholdsOptions",
    "MapperOptions",
    "MapBudget",
    "WorldAreasRoomSegmentationOptions",
    "WorldAreasNamingOptions",
    "WorldAreasOptions",
    "WorldInstanceMapOptions",
    "WorldOdometryOptions",
    "WorldOptions",
    "LocalizerFilterOptions",
    "LocalizerOptions",
    "RouteOptions",
    "ExportOptions",
    "ZoneOptions",
    "ZoneStreamOptions",
    "ClassifierOptions",
    "CloudFileOptions",
    "FilterGngOptions",
    "FilterOptions",
    "GngOptions",
    "NormalOptions",
    "ClusterOptions",
    "RecognitionModelFilterOptions",
    "RecognitionOptions",
    "CollectOptions",
    "TrainingShapeOptions",
    "TrainingClassifierOptions",
    "TrainingOptions",
    "PredictOptions",
    "RgbdOptions",
    "ReplayOptions",
    "ComparisonOptions",
]

Text = Union[str, "os.PathLike[str]", "list[str]"]
"""A text, a path, or a list that becomes one with commas."""


class SequenceOptions(TypedDict, total=False):
    """How to open a sequence of images."""
    type: Literal[
        "auto",
        "descriptors",
        "bag",
        "video",
        "tum",
        "sevenscenes",
        "panorama",
        "idol2",
        "nyu",
        "rgbd",
        "vidrilo",
        "classes",
        "folder",
    ]
    """Format of the sequence. One of auto, descriptors, bag, video, tum, sevenscenes, panorama, idol2, nyu, rgbd,
    vidrilo, classes, folder; default: auto."""
    poses: Text
    """Trajectory (TUM or KITTI). A text; default: poses.txt in the folder."""
    rooms: Text
    """CSV image,room or image,room,split. A text; default: rooms.csv in the folder."""
    split: Text
    """Only the frames of this split. A text; default: all frames."""
    only: Text
    """Only the frames in these rooms, separated by commas. A text; default: all rooms."""
    max_pose_gap: float
    """Largest time difference between a frame and its pose. Raise it for slow or badly synchronized trajectories. A
    number of at least 0 s; default: 0.05."""
    depth_scale: float
    """Depth units per meter; 0: that of the data set or image type. Set it when depth images are not in millimeters. A
    number from 0 to 1000000000; default: 0."""
    intrinsics: Text
    """Camera intrinsics: fx fy cx cy, 3×3 matrix, or YAML. A text; default: camera-intrinsics.txt, intrinsics.txt or
    camera.yaml in the folder."""
    image_topic: Text
    """Bags: topic of images, raw or compressed. A text; default: the only camera, or the only one with color."""
    depth_topic: Text
    """Bags: topic of depth images; none: without depth. A text; default: the only one, or the only one in the frame of
    the images."""
    odom_topic: Text
    """Bags: topic of odometry, poses or transforms; none: without poses. A text; default: tf, else the only one."""
    views: int
    """Panoramas: views per place, evenly spaced. A whole number from 1 to 360; default: 12."""
    field_of_view: float
    """Panoramas: horizontal field of view. A number from 10 to 150 degrees; default: 80."""
    turn: float
    """Panoramas: offset of all headings. Gives another tour of the same places. A number in degrees; default: 0."""
    exposure: float
    """Panoramas: change of exposure. Simulates another illumination. A number from -20 to 20 EV; default: 0."""
    rounds: int
    """Panoramas: how often the tour visits all places. A whole number from 1 to 1000; default: 1."""


class CheckOptions(TypedDict, total=False):
    """Check of a sequence."""
    max_frames: int
    """Largest number of frames that are checked, evenly spread. More take longer and find rarer faults. A whole number
    of at least 1; default: 60."""


class LabelerOptions(TypedDict, total=False):
    """How a model is run."""
    engine: Text
    """What runs the network: onnxruntime or opencv. OpenCV opens more formats; ONNX Runtime is two to four times as
    fast. A text; default: the fastest that can open it."""
    threads: int
    """Threads of the network; 0 = one per free core. Leaves cores to other work. A whole number from 0 to 1024;
    default: 0."""
    on_demand: bool
    """Open the network at its first frame only. A run whose labels are all cached opens none. True or false; default:
    false."""
    precision: Literal["float32", "int8"]
    """How exactly the network computes. Large networks label 1.8 times the images a second; maps and labels of the
    other precision do not fit. One of float32, int8; default: float32."""
    reduced_images: bool
    """Decode JPEG files at 1/2, 1/4 or 1/8 of their size, but no smaller than the network's input. Reading takes longer
    than a small network; maps and labels of whole images do not fit. True or false; default: false."""


class LabelStreamOptions(TypedDict, total=False):
    """How a sequence is labeled."""
    first: int
    """The first frame to label. A whole number of at least 0 frames; default: 0."""
    strict: bool
    """Stop at an unreadable frame instead of skipping it. A data set of which nothing may be missing. True or false;
    default: false."""


class LabelFileOptions(TypedDict, total=False):
    """The files beside a descriptor file."""
    labels: Text
    """Label file, one label per line. A text; default: the labels of the file."""
    frames: Text
    """Names of the rows of a .npy file. A text; default: NAME.frames.csv."""


class MapperThresholdsOptions(TypedDict, total=False):
    """How the thresholds are estimated from the run itself."""
    far_quantile: float
    """Share of the pairs of different places within tau-join. A larger share gives fewer, larger places. A number from
    0 to 1; default: 0.03."""
    revisit_ratio: float
    """tau-revisit / tau-join. A smaller ratio needs more evidence before an earlier place is recognized. A number of at
    least 0; default: 0.4."""
    merge_ratio: float
    """tau-merge / tau-join, between the means of two nodes. 0 never merges nodes. A number of at least 0; default: 0.3.
    tau-merge / tau-join, between the means of two nodes. 0 never merges nodes. A number of at least 0; default: 0.3."""


class MapperOptions(TypedDict, total=False):
    """How frames become places."""
    distance: Literal[
        "standardized-clr",
        "standardized-clr-sigma",
        "clr-cosine",
        "clr-cosine-sigma",
        "clr-euclidean",
        "clr-euclidean-sigma",
        "hellinger",
        "hellinger-sigma",
        "bhattacharyya",
        "bhattacharyya-sigma",
        "jensen-shannon",
        "jensen-shannon-sigma",
        "kullback-leibler",
        "kullback-leibler-sigma",
        "l1",
        "l1-sigma",
        "l2",
        "l2-sigma",
        "cosine",
        "cosine-sigma",
        "pearson",
        "pearson-sigma",
        "chi2",
        "chi2-sigma",
        "ks",
        "ks-sigma",
        "cumulative-ks",
        "cumulative-ks-sigma",
        "weighted",
        "weighted-root",
    ]
    """Distance of a frame to a node. One of standardized-clr, standardized-clr-sigma, clr-cosine, clr-cosine-sigma,
    clr-euclidean, clr-euclidean-sigma, hellinger, hellinger-sigma, bhattacharyya, bhattacharyya-sigma, jensen-
    shannon, jensen-shannon-sigma, kullback-leibler, kullback-leibler-sigma, l1, l1-sigma, l2, l2-sigma, cosine,
    cosine-sigma, pearson, pearson-sigma, chi2, chi2-sigma, ks, ks-sigma, cumulative-ks, cumulative-ks-sigma,
    weighted, weighted-root; default: standardized-clr."""
    tau_join: float
    """A frame within this distance stays in the current node. A larger distance gives fewer, larger places. Auto, or a
    number above 0; default: estimated from the run."""
    tau_revisit: float
    """A frame within this distance of another node returns to that node. A smaller distance recognizes fewer places
    again. Auto, or a number above 0; default: revisit-ratio times tau-join."""
    views: int
    """Images kept in all of the places, to recognize these from another side and by poses. 0: places are recognized by
    their means alone. A whole number of at least 0 images; default: 2048."""
    near_distance: float
    """Frames this far apart can show the same place. Views change over a shorter way in narrow rooms than in halls and
    streets. A number above 0 m; default: 0.7."""
    near_angle: float
    """Frames whose directions differ by this can show the same place. A wide field of view allows more. A number above
    0 degrees; default: 30."""
    transition_images: int
    """The first and last K frames of a node weigh 0, 1/K, … in it. Frames between two places show both of them. A whole
    number from 0 to 1000 frames; default: 0."""
    warmup_frames: int
    """These first keyframes are remapped each time the thresholds are estimated again. A longer warm-up costs memory,
    and nodes may change for longer. A whole number of at least 0 keyframes; default: 600."""
    thresholds: MapperThresholdsOptions
    """How the thresholds are estimated from the run itself."""


class MapBudget(TypedDict, total=False):
    """How much memory and how large a file a map may take."""
    memory: int
    """Most memory for places, their views and what guides a drive. Places that hold few images become parts of their
    neighbors, where they do not all fit. Auto, or a whole number from 1 to 1000000000 MB; default: as much as they
    take."""
    file_budget: int
    """Most bytes of the map file. The images that say least beside the others of their places are left out. Auto, or a
    whole number from 1 to 1000000000 MB; default: as much as it takes."""


class WorldAreasRoomSegmentationOptions(TypedDict, total=False):
    """How free space is split into rooms."""
    mutual_visibility: float
    """Two sides of a passage are one room where more than this share of their points see each other. Smaller values
    merge rooms with wide openings. A number from 0 to 1; default: 0.75."""


class WorldAreasNamingOptions(TypedDict, total=False):
    """Which words name zones and areas."""
    words: Literal["wordnet", "raw"]
    """The words that zones and areas are called by. One of wordnet, raw; default: wordnet."""


class WorldAreasOptions(TypedDict, total=False):
    """How a drive becomes areas."""
    cell: float
    """Width of a cell of the floor plan. Narrower than the thinnest wall, wider than the noise of the poses. A number
    from 0.01 to 1 m; default: 0.05."""
    room_segmentation: WorldAreasRoomSegmentationOptions
    """How free space is split into rooms."""
    naming: WorldAreasNamingOptions
    """Which words name zones and areas."""


class WorldInstanceMapOptions(TypedDict, total=False):
    """How segments become things that last."""
    voxel: float
    """Width of a voxel. Wider than the noise of depth and poses, narrower than the gaps between things. A number from
    0.005 to 0.2 m; default: 0.025."""
    consensus: float
    """Share of the frames that see two segments and have them in one, for them to be one thing. A number above 0 and up
    to 1; default: 0.6."""
    min_views: int
    """Frames that must show a thing. A whole number of at least 1; default: 4."""


class WorldOdometryOptions(TypedDict, total=False):
    """RGB-D odometry."""
    term: Literal["auto", "depth", "color", "hybrid"]
    """What alignment minimizes. One of auto, depth, color, hybrid; default: auto."""
    max_width: int
    """Images are halved until they are at most this wide. Larger images take longer, and gain little with the noise of
    depth cameras. A whole number from 48 to 4096 pixels; default: 160."""
    max_depth: float
    """Depth beyond is not used. A number above 0 and up to 1000 m; default: 8."""
    min_loop_features: int
    """Features that must agree for a loop closure. Raise it where rooms look alike. A whole number of at least 6;
    default: 25."""
    threads: int
    """Threads; 0: one a free core. The result does not depend on it. A whole number from 0 to 1024; default: 0."""


class WorldOptions(TypedDict, total=False):
    """How a drive becomes areas and objects."""
    layers: Text
    """What the map holds: places,zones,areas,objects, some of them. A text; default: all that the drive allows."""
    view_shift: float
    """How far the camera moves to a new view. A robot that stands still sees nothing new. A number from 0 to 10 m;
    default: 0.05."""
    view_turn: float
    """How far the camera turns to a new view. A number from 0 to 180 degrees; default: 3."""
    crops: int
    """Objects that are labeled for each frame: new ones and better views first. Each costs as much as the frame itself.
    A whole number from 0 to 1000; default: 1."""
    areas: WorldAreasOptions
    """How a drive becomes areas."""
    clusters: ClusterOptions
    """Segmentation of a depth image or cloud into objects."""
    instance_map: WorldInstanceMapOptions
    """How segments become things that last."""
    odometry: WorldOdometryOptions
    """RGB-D odometry."""


class LocalizerFilterOptions(TypedDict, total=False):
    """Motion model and evidence of the Bayes filter."""
    near_distance: float
    """Frames this far apart can show the same view. Views change over a shorter way in narrow rooms than in halls and
    streets. A number above 0 m; default: 0.7."""
    near_angle: float
    """Frames whose directions differ by this can show the same view. A wide field of view allows more. A number above 0
    degrees; default: 30."""


class LocalizerOptions(TypedDict, total=False):
    """How frames are found in a map."""
    lookahead: int
    """Answer this many frames late (fixed-lag smoothing). Later frames tell more; 0 answers at once. A whole number of
    at least 0 frames; default: 0."""
    max_images: int
    """Compare with at most this many stored frames, evenly thinned. Fewer take less memory and time. A whole number of
    at least 1; default: 50000."""
    filter: LocalizerFilterOptions
    """Motion model and evidence of the Bayes filter."""


class RouteOptions(TypedDict, total=False):
    """How the way to a place is found."""
    bidirectional: bool
    """Drive transitions backwards, too. Off where doors or lanes are one-way. True or false; default: true."""
    tolerance: float
    """Places within this share of the best one's probability hold a word equally well: the nearest is taken. 0 always
    drives to the most probable place. A number from 0 to 1; default: 0.1."""
    avoid_factor: float
    """A meter in an area that is to be avoided costs as much as so many elsewhere. A detour is taken while it is
    shorter than that; no area is ever out of reach. A number from 1 to 1000; default: 5."""
    prefer_factor: float
    """A meter in a preferred area costs as much as so many elsewhere. A way through it may be twice as long. A number
    from 0.001 to 1; default: 0.5."""
    view_angle: float
    """An object whose middle is within this angle of where a frame looks was in its view [degrees]. Usual depth cameras
    see 21° up and down, and more to the sides. A number from 1 to 90; default: 20."""


class ExportOptions(TypedDict, total=False):
    """How a map is written for other programs."""
    max_words: int
    """Largest number of labels for each place. A whole number of at least 0; default: 10."""
    frame: Text
    """nav2: the coordinate frame of the poses, as the robot's TF tree names it. A text; default: map."""
    bidirectional: bool
    """nav2: an edge each way for every transition. Off where doors or lanes are one-way. True or false; default: true.
    nav2: an edge each way for every transition. Off where doors or lanes are one-way. True or false; default: true."""


class ZoneOptions(TypedDict, total=False):
    """How images become zones."""
    distance: Literal[
        "standardized-clr",
        "clr-cosine",
        "clr-euclidean",
        "hellinger",
        "bhattacharyya",
        "jensen-shannon",
        "kullback-leibler",
        "l1",
        "l2",
        "cosine",
        "pearson",
        "chi2",
        "ks",
        "cumulative-ks",
    ]
    """Distance of two images. One of standardized-clr, clr-cosine, clr-euclidean, hellinger, bhattacharyya, jensen-
    shannon, kullback-leibler, l1, l2, cosine, pearson, chi2, ks, cumulative-ks; default: standardized-clr."""
    linkage: Literal["average", "ward", "complete", "weighted", "single"]
    """Distance of two zones. One of average, ward, complete, weighted, single; default: ward."""
    cut: float
    """Zones merge up to this distance (tau_d). A larger distance gives fewer, larger zones. Auto, or a number of at
    least 0; default: where the modularity of the zones is largest."""
    count: int
    """This number of zones, instead of a cut. Auto, or a whole number of at least 1; default: by the cut."""
    reach: float
    """Images of a run that were taken within about this distance are compared by what is seen from all of them. A
    larger distance gives fewer, larger zones. Auto, or a number of at least 0 m; default: 0.5 for a map; 0, each
    image by itself, for images in any order."""
    threads: int
    """Threads of the clustering. 0: one a usable core. A whole number from 0 to 1024; default: 0."""
    naming: WorldAreasNamingOptions
    """Which words name zones and areas."""


class ZoneStreamOptions(TypedDict, total=False):
    """How zones are kept up to date while images come."""
    groups: int
    """At most this many groups of similar images stand for the run. More are nearer to the exact zones, and slower by
    their square. A whole number from 2 to 20000; default: 512."""


class ClassifierOptions(TypedDict, total=False):
    """Training of a classifier."""
    type: Literal["svm-linear", "svm-rbf", "linear", "forest", "knn"]
    """Type of classifier. One of svm-linear, svm-rbf, linear, forest, knn; default: svm-rbf."""
    balanced: bool
    """Give each class the same weight, whatever its number of samples. Where accuracy on rare classes matters as much
    as on frequent ones. True or false; default: false."""
    folds: int
    """Folds of the cross-validation that finds parameters. A whole number from 2 to 1000000; default: 5."""
    seed: int
    """Seed of the folds and of random forests. A whole number of at least 0; default: 1."""
    threads: int
    """Threads; 0: one a usable core. Results do not depend on it. A whole number of at least 0; default: 0."""
    c: float
    """svm-linear, svm-rbf, linear: cost of an error. Larger values fit the training data more closely. Auto, or a
    number above 0; default: found by cross-validation."""
    gamma: float
    """svm-rbf: gamma of the kernel exp(-gamma |a - b|^2). Auto, or a number above 0; default: found by cross-
    validation."""
    neighbors: int
    """knn: neighbors that vote. Auto, or a whole number of at least 1; default: found by cross-validation."""
    metric: Literal["euclidean", "cosine", ""]
    """knn: distance of samples. One of euclidean, cosine; default: found by cross-validation."""
    trees: int
    """forest: number of trees. A whole number of at least 1; default: 500."""


class CloudFileOptions(TypedDict, total=False):
    """How to read depth images as point clouds."""
    depth_scale: float
    """Depth units per meter; 0: default of the image type. A number from 0 to 1000000000; default: 0."""
    intrinsics: Text
    """Camera intrinsics: fx fy cx cy, 3×3 matrix, or YAML. A text; default: camera-intrinsics.txt, intrinsics.txt or
    camera.yaml in the folder or the one above."""
    colors: Text
    """Color image of the same view. A text; default: no colors."""


class FilterGngOptions(TypedDict, total=False):
    """Growing Neural Gas."""
    signals_per_insertion: int
    """Signals between two insertions (λ). More fit the surface better and take proportionally longer. A whole number of
    at least 1; default: 2000."""
    winner_rate: float
    """Share of the way to a signal that the winner moves. A number above 0 and up to 1; default: 0.1."""
    neighbor_rate: float
    """Share of the way that neighbors of the winner move. A number from 0 to 1; default: 0.001."""
    insertion_decay: float
    """Share of their error that both parents of a new neuron keep. A number from 0 to 1; default: 0.5."""
    error_decay: float
    """Share of its error that every neuron keeps at an insertion. A number above 0 and up to 1; default: 0.995."""
    max_age: int
    """Age above which edges are removed. A whole number of at least 0; default: 250."""
    color_weight: float
    """Weight of colors beside positions; 0: positions only. With 1 the noise of the colors counts as much as the
    spacing of the points. A number from 0 to 1000000; default: 0."""
    seed: int
    """Seed of the signals. A whole number of at least 0; default: 1."""
    quantization_error: float
    """Stop below this quantization error; 0: never. A number of at least 0 unit of the cloud; default: 0."""
    seconds: float
    """Stop after this time; 0: never. The result is then not reproducible. A number of at least 0 s; default: 0."""


class FilterOptions(TypedDict, total=False):
    """Point cloud filter."""
    method: Literal["none", "voxel", "gng"]
    """Filter. One of none, voxel, gng; default: none."""
    points: int
    """Points of the result. A whole number of at least 1; default: 20000."""
    leaf: float
    """Edge of a voxel. A number of at least 0 m; default: 0."""
    gng: FilterGngOptions
    """Growing Neural Gas."""


class GngOptions(TypedDict, total=False):
    """Growing Neural Gas."""
    neurons: int
    """Neurons of the network. A whole number from 2 to 100000000; default: 20000."""
    signals_per_insertion: int
    """Signals between two insertions (λ). More fit the surface better and take proportionally longer. A whole number of
    at least 1; default: 2000."""
    winner_rate: float
    """Share of the way to a signal that the winner moves. A number above 0 and up to 1; default: 0.1."""
    neighbor_rate: float
    """Share of the way that neighbors of the winner move. A number from 0 to 1; default: 0.001."""
    insertion_decay: float
    """Share of their error that both parents of a new neuron keep. A number from 0 to 1; default: 0.5."""
    error_decay: float
    """Share of its error that every neuron keeps at an insertion. A number above 0 and up to 1; default: 0.995."""
    max_age: int
    """Age above which edges are removed. A whole number of at least 0; default: 250."""
    color_weight: float
    """Weight of colors beside positions; 0: positions only. With 1 the noise of the colors counts as much as the
    spacing of the points. A number from 0 to 1000000; default: 0."""
    seed: int
    """Seed of the signals. A whole number of at least 0; default: 1."""
    quantization_error: float
    """Stop below this quantization error; 0: never. A number of at least 0 unit of the cloud; default: 0."""
    seconds: float
    """Stop after this time; 0: never. The result is then not reproducible. A number of at least 0 s; default: 0."""


class NormalOptions(TypedDict, total=False):
    """Surface normals."""
    radius: float
    """Radius of the points that a plane is fitted to; 0: neighbors decides. Larger radii average noise away and round
    edges off. A number of at least 0 m; default: 0."""
    neighbors: int
    """Nearest points that a plane is fitted to; 0: radius decides. A whole number of at least 0; default: 0."""
    threads: int
    """Threads; 0: one a usable core. A whole number of at least 0; default: 0."""


class ClusterOptions(TypedDict, total=False):
    """Segmentation of a depth image or cloud into objects."""
    min_points: int
    """Points of the smallest cluster: pixels at a focal length of 525, or points of an unorganized cloud. Lower it for
    small or distant objects. A whole number of at least 0; default: 400."""
    threads: int
    """Threads; 0: one a usable core. The result does not depend on it. A whole number of at least 0; default: 0."""


class RecognitionModelFilterOptions(TypedDict, total=False):
    """Point cloud filter."""
    method: Literal["none", "voxel", "gng"]
    """Filter. One of none, voxel, gng; default: none."""
    points: int
    """Points of the result. A whole number of at least 1; default: 20000."""


class RecognitionOptions(TypedDict, total=False):
    """Recognition of known objects in a point cloud."""
    surface: Literal["filtered", "mean"]
    """Surface that is described. One of filtered, mean; default: mean."""
    keypoints: Literal["uniform", "harris3d", "iss"]
    """Keypoint detector. One of uniform, harris3d, iss; default: uniform."""
    descriptor: Literal["shot", "shot-color", "fpfh", "spin-image"]
    """Descriptor of a keypoint. One of shot, shot-color, fpfh, spin-image; default: shot."""
    grouping: Literal["geometric-consistency", "hough", "local-frames"]
    """How matches become poses. One of geometric-consistency, hough, local-frames; default: local-frames."""
    verification: Literal["global", "inliers", "evidence"]
    """Which poses are accepted. One of global, inliers, evidence; default: evidence."""
    accept: float
    """Smallest supported share of the visible model, where poses are verified by inliers. Raise it against false
    detections, lower it for objects that are hidden in part. A number from 0 to 1; default: 0.6."""
    false_alarm_rate: float
    """Largest probability that a model that is not in the scene is found, where poses are verified by evidence. Lower
    it when many models are searched, raise it for objects that are hidden in part. A number above 0 and up to 1;
    default: 0.01."""
    normal_radius: float
    """Radius of the points that a normal is fitted to. A number of at least 0 m; default: 0."""
    normal_neighbors: int
    """Nearest points that a normal of a filtered surface is fitted to; 0: by radius. A whole number of at least 0;
    default: 0."""
    keypoint_spacing: float
    """Distance of uniform keypoints, or support of a detector. A number of at least 0 m; default: 0."""
    descriptor_radius: float
    """Support radius of a descriptor. A number of at least 0 m; default: 0."""
    consistency: float
    """Tolerance within which matches agree, and bin size of Hough voting. A number of at least 0 m; default: 0."""
    tolerance: float
    """Distance between a model point and the scene point that supports it. A number of at least 0 m; default: 0."""
    color_tolerance: float
    """Largest color difference between a model point and the scene point that supports it, in CIELAB with half the
    lightness, by which poses are also refined; 0: colors do not count. Only with local-frames and evidence, and if
    both clouds have colors. Tells objects of one shape apart. Raise it where the light differs. A number from 0 to
    300; default: 0."""
    viewpoint: Text
    """Position of the scene's sensor: X,Y,Z; none: several views in one cloud. A text; default: that of the cloud, else
    the origin."""
    threads: int
    """Threads; 0: one a usable core. Results do not depend on it. A whole number of at least 0; default: 0."""
    model_filter: RecognitionModelFilterOptions
    """Point cloud filter."""
    scene_filter: RecognitionModelFilterOptions
    """Point cloud filter."""


class CollectOptions(TypedDict, total=False):
    """Collection of object samples from a sequence."""
    first: int
    """First frame. A whole number of at least 0; default: 0."""
    every: int
    """Use every N-th frame. A whole number of at least 1; default: 1."""
    max_frames: int
    """Number of frames; 0: all. A whole number of at least 0; default: 0."""
    max_views: int
    """Largest number of views of one object (thesis Table 6.2). A whole number of at least 1; default: 500."""
    clusters: Literal["convexity", "euclidean"]
    """What an object is. Euclidean to repeat the thesis; things that touch are one then. One of convexity, euclidean;
    default: convexity."""
    replace: bool
    """Replace the samples in an existing folder. True or false; default: false."""
    strict: bool
    """Fail at a frame that cannot be read instead of skipping it. True or false; default: false."""


class TrainingShapeOptions(TypedDict, total=False):
    """Shape descriptor of objects."""
    samples: int
    """Triples of points that ESF draws. Fewer are faster and noisier. A whole number from 1 to 1000000; default: 5000.
    Triples of points that ESF draws. Fewer are faster and noisier. A whole number from 1 to 1000000; default: 5000."""
    size: bool
    """Also describe the metric size. If objects of different classes have the same shape, but other sizes. True or
    false; default: false."""
    threads: int
    """Threads; 0: one a usable core. The numbers do not depend on it. A whole number of at least 0; default: 0."""


class TrainingClassifierOptions(TypedDict, total=False):
    """Training of a classifier."""
    type: Literal["svm-linear", "svm-rbf", "linear", "forest", "knn"]
    """Type of classifier. One of svm-linear, svm-rbf, linear, forest, knn; default: svm-rbf."""
    balanced: bool
    """Give each class the same weight, whatever its number of samples. Where accuracy on rare classes matters as much
    as on frequent ones. True or false; default: false."""
    seed: int
    """Seed of the folds and of random forests. A whole number of at least 0; default: 1."""
    threads: int
    """Threads; 0: one a usable core. Results do not depend on it. A whole number of at least 0; default: 0."""


class TrainingOptions(TypedDict, total=False):
    """Self-supervised training of an object model."""
    pseudo_labels: Literal["top", "voted", "confident"]
    """How class probabilities become pseudo-labels. One of top, voted, confident; default: voted."""
    correct_prior: bool
    """Divide the labeler's probabilities by how often it gives each class. Off if the classes really are as frequent as
    the labeler says. True or false; default: true."""
    min_coverage: float
    """Objects whose labels cover the target classes less than this on average are of no target class. Raise it if other
    objects are learned as targets. A number from 0 to 1; default: 0."""
    all_views: bool
    """Also use flat views and those cut by the image border, which do not show the whole shape. True or false; default:
    false."""
    split: Text
    """Use only the views of this part of the data set. A text; default: all views."""
    shape: TrainingShapeOptions
    """Shape descriptor of objects."""
    classifier: TrainingClassifierOptions
    """Training of a classifier."""


class PredictOptions(TypedDict, total=False):
    """Classification of the objects of a sequence."""
    threads: int
    """Threads; 0: one a usable core. Answers do not depend on it. A whole number of at least 0; default: 0."""


class RgbdOptions(TypedDict, total=False):
    """RGB-D odometry."""
    term: Literal["auto", "depth", "color", "hybrid"]
    """What alignment minimizes. One of auto, depth, color, hybrid; default: auto."""
    max_width: int
    """Images are halved until they are at most this wide. Larger images take longer, and gain little with the noise of
    depth cameras. A whole number from 48 to 4096 pixels; default: 160."""
    max_depth: float
    """Depth beyond is not used. A number above 0 and up to 1000 m; default: 8."""
    odom_shift: float
    """Uncertainty of the prior's motion: standard deviation of a step's length, of that length. A number above 0 and up
    to 1000 %; default: 3."""
    odom_turn: float
    """Uncertainty of the prior's turn: standard deviation of a step. A number above 0 and up to 180 degrees; default:
    2."""
    min_loop_features: int
    """Features that must agree for a loop closure. Raise it where rooms look alike. A whole number of at least 6;
    default: 25."""
    threads: int
    """Threads; 0: one a free core. The result does not depend on it. A whole number from 0 to 1024; default: 0."""


class ReplayOptions(TypedDict, total=False):
    """How a recording is played."""
    rate: float
    """Play so many times as fast as it was recorded. 0 plays as fast as frames are taken, so that none is dropped. A
    number from 0 to 1000; default: 1."""
    frames_per_second: float
    """Of recordings without time stamps. A number from 0.001 to 1000 Hz; default: 10."""


class ComparisonOptions(TypedDict, total=False):
    """Statistical comparison of methods over several tests."""
    better: Literal["larger", "smaller"]
    """Whether larger or smaller scores are better. One of larger, smaller; default: larger."""
    post_hoc: Literal["holm", "shaffer", "nemenyi"]
    """Post-hoc test. Holm compares with a control and is the most powerful; the others compare all pairs. One of holm,
    shaffer, nemenyi; default: holm."""
    alpha: float
    """Probability of finding any difference where there is none. Smaller values find fewer differences, and are more
    often right. A number above 0 and up to 0.9999999999999999; default: 0.05."""
    control: Text
    """Method that the others are compared with. A text; default: the method of the best mean rank."""

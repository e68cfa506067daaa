// Forward declarations: the types of the public API, for headers that only name them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace estancia {

// core
struct CameraIntrinsics;
struct Choice;
struct DescriptorLayout;
class DescriptorMatrix;
class Error;
class Floor;
struct Frame;
class Interrupted;
struct LabelPart;
struct LabelProbability;
class NoAnswerError;
class Option;
class OptionGroup;
struct PlanarMotion;
struct PlanarPose;
struct PointCloud;
struct Pose;
class Progress;
struct RoomEvidence;
struct RoomPredictions;
struct RoomProbability;
class Vocabulary;

// stats
class Dendrogram;

// words
struct LabelConcept;
struct LabelMatch;
struct LabelMatches;
class Lexicon;
struct NamingOptions;
struct WordAssociation;
struct WordGraph;

// files
struct CloudFileOptions;

// sequences
struct DescriptorFileOptions;
struct DescriptorSequence;
struct PoseSource;
class Sequence;
struct SequenceOptions;
struct Trajectory;
struct TrajectoryPoint;

// readers
struct ObjectImage;
struct ObjectView;
class ObjectViews;
struct ObjectViewsOptions;

// labelers
class BatchError;
class FrameError;
struct InstalledModel;
struct LabelResult;
class Labeler;
struct LabelerOptions;
struct ModelCheck;
struct ModelSpec;
struct Prepared;
struct Preprocessing;

// label
class LabelCache;
class LabelStream;
struct LabelStreamOptions;
struct LabeledFrame;

// describe
struct DescribeOptions;
class Descriptor;
struct DescriptorPart;
struct Features;
struct NamedDescriptor;
struct View;

// cloud
struct CropOptions;
struct FilterOptions;
struct FilteredCloud;
struct GngOptions;
struct NeuralGas;

// segmentation
struct Cluster;
struct ClusterOptions;
struct Clusters;
struct Plane;

// odometry
struct FrameWords;
struct RgbdOptions;
struct RgbdTrajectory;

// check
struct CheckItem;
struct CheckOptions;
struct CheckReport;

// map_file
struct Decision;
struct Drive;
struct MappedFrame;
struct Merge;
struct Node;
struct TopologicalMap;
struct Transition;
struct Visit;

// mapper
struct MapChanges;
class Mapper;
struct MapperOptions;
struct ThresholdOptions;
struct Thresholds;

// localization
struct Localization;
class Localizer;
struct LocalizerOptions;
struct PlaceFilterOptions;

// session
struct CompactedMap;
struct DriveStart;
struct MapBudget;
class MappingSession;

// query
struct Answers;
struct DriveSummary;
struct ExportOptions;
struct Meaning;
struct PlaceAnswer;
struct Route;
struct RouteOptions;
struct WordRoute;

// zones
struct RoomWords;
struct StreamedZone;
struct Zone;
struct ZoneExtent;
struct ZoneOptions;
class ZoneStream;
struct ZoneStreamOptions;
struct Zones;

// classify
class Classifier;
struct ClassifierOptions;
class RoomClassifier;
struct Samples;

// recognition
struct Detection;
struct RecognitionOptions;
class Recognizer;
struct StageReport;

// objects
struct CollectOptions;
struct Collected;
struct FusedAnswer;
struct LabeledViews;
class ObjectModel;
class ObjectPredictor;
struct ObjectTraining;
struct PredictOptions;
struct PredictSeconds;
struct PredictedObject;
struct ShapeOptions;
struct TargetClasses;
struct TrainingOptions;
struct TrainingSet;

// areas
struct Area;
struct AreaEdit;
struct AreaPlan;
class FloorCells;

// world_file
struct KnownPose;
struct ObjectEdit;
struct WorldArea;
struct WorldLayers;
struct WorldMap;
struct WorldObject;
struct WorldOptions;
struct WorldZone;

// world
struct DriveFaults;
struct MapLevel;
struct MapSequenceOptions;
struct MappedSequence;
struct PoseJump;
class WorldMapper;

// world_query
struct Changes;
struct CrossedRegion;
struct DrivenWay;
struct MapRegion;
struct ObjectAnswer;
struct ObjectChange;
struct PlaceChange;
struct RegionCosts;
struct RegionPreferences;
struct ViewPose;
struct WayPiece;
struct WorldAnswers;
struct WorldMeaning;
struct WorldRoute;

// joining
struct MergedMaps;
struct ShareWork;

// figures
struct FloorPlan;

// report
struct MapPage;
struct Measure;
struct PageImages;
struct WorldPage;
struct ZonesPage;

// sources
class FrameSource;
struct FrameSourceOptions;
struct LiveFrame;
struct ReplayOptions;

// live
struct DeleteObject;
class LiveLoop;
struct LiveOptions;
struct LiveStatus;
class LiveView;
struct MergeAreas;
struct NameArea;
struct NameObject;
struct PlaceBelief;
struct SplitArea;

}  // namespace estancia

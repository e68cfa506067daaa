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
struct RoomPredictions;
struct RoomProbability;
class Vocabulary;

// stats
struct Agreement;
struct ComparisonOptions;
class CondensedDistances;
class Dendrogram;
struct Distance;
struct FriedmanTest;
struct MethodComparison;
struct MethodScores;
struct MethodStanding;
struct PairTest;
struct WilcoxonTest;
struct WinRecord;

// words
struct FamiliarWord;
struct LabelConcept;
struct LabelMatch;
struct LabelMatches;
class LabelSearch;
struct LabelSense;
class Lexicon;
struct NameMatch;
struct NamingOptions;
struct Sense;
struct TellingWord;
struct WordGraph;
struct WordNet;
struct WordNetEntry;
struct WordNetSynset;

// io
struct CloudFileOptions;
struct DescriptorFileOptions;
struct DescriptorSequence;
struct ObjectImage;
struct ObjectView;
class ObjectViews;
struct ObjectViewsOptions;
struct PoseSource;
class Sequence;
struct SequenceOptions;
struct Trajectory;
struct TrajectoryPoint;

// label
class BatchError;
class FrameError;
struct InstalledModel;
class LabelCache;
struct LabelResult;
class LabelStream;
struct LabelStreamOptions;
struct LabeledFrame;
class Labeler;
struct LabelerOptions;
struct ModelCheck;
struct ModelSpec;
struct Prepared;
struct Preprocessing;

// describe
struct DescribeOptions;
class Descriptor;
struct DescriptorPart;
struct Features;
struct NamedDescriptor;
struct View;

// cloud
struct Cluster;
struct ClusterOptions;
struct Clusters;
struct CropOptions;
struct FilterOptions;
struct FilteredCloud;
struct GngOptions;
struct NeuralGas;
struct NormalOptions;
struct Plane;

// odometry
struct FrameFacts;
struct FrameWords;
struct RgbdOptions;
class RgbdTracker;
struct RgbdTrajectory;

// check
struct CheckItem;
struct CheckOptions;
struct CheckReport;

// topology
struct Answers;
struct Decision;
struct ExportOptions;
struct Localization;
class Localizer;
struct LocalizerOptions;
struct MapChanges;
struct MapQuality;
struct MappedFrame;
class Mapper;
struct MapperOptions;
class MappingSession;
struct Meaning;
struct Merge;
struct Node;
struct OriginalScore;
struct PlaceAnswer;
struct PlaceFilterOptions;
struct Route;
struct RouteOptions;
struct ThresholdOptions;
struct Thresholds;
struct TopologicalMap;
struct Transition;
struct WordRoute;

// zones
struct RoomWords;
struct StreamAgreement;
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
struct Confusion;
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
struct TrackOptions;
struct TrainingOptions;
struct TrainingSet;

// areas
struct Area;
struct AreaEdit;
struct AreaPlan;
class FloorCells;
struct FloorHeat;
struct FloorSurvey;
class OccupancyGrid;
struct PlannedFrames;
struct RoomSegmentationOptions;
class WordMap;
struct WordMapOptions;

// world
struct KnownPose;
struct MapSequenceOptions;
struct MappedSequence;
struct WorldArea;
struct WorldMap;
struct WorldObject;
struct WorldOptions;
struct WorldZone;

// report
struct CloudLayer;
struct CloudView;
struct FloorPlan;
struct MapPage;
struct Measure;
struct PageImages;
struct WorldPage;
struct ZonesPage;

// live
struct DeleteObject;
class FrameSource;
struct FrameSourceOptions;
struct LiveFrame;
class LiveLoop;
struct LiveOptions;
struct LiveStatus;
class LiveView;
struct MergeAreas;
struct NameArea;
struct NameObject;
struct PlaceBelief;
struct ReplayOptions;
class ReplaySource;
struct SplitArea;

}  // namespace estancia

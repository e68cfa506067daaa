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

// distances
struct Distance;

// stats
struct Agreement;
struct ComparisonOptions;
class CondensedDistances;
class Dendrogram;
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
struct NormalOptions;

// segmentation
struct Cluster;
struct ClusterOptions;
struct Clusters;
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

// map_file
struct Decision;
struct Drive;
struct MappedFrame;
struct Merge;
struct Node;
struct TopologicalMap;
struct Transition;

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
struct DriveStart;
struct MapBudget;
class MappingSession;

// query
struct Answers;
struct DriveSummary;
struct ExportOptions;
struct MapQuality;
struct Meaning;
struct OriginalScore;
struct PlaceAnswer;
struct Route;
struct RouteOptions;
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
struct TrainingOptions;
struct TrainingSet;

// areas
struct Area;
struct AreaEdit;
struct AreaPlan;
struct DrivePoses;
class FloorCells;
struct FloorHeat;
struct FloorSurvey;
class FramePoses;
class OccupancyGrid;
struct PlannedFrames;
struct RoomSegmentationOptions;
class WordMap;

// world_file
struct KnownPose;
struct WorldArea;
struct WorldMap;
struct WorldObject;
struct WorldOptions;
struct WorldZone;

// world
struct MapSequenceOptions;
struct MappedSequence;

// world_query
struct Changes;
struct ObjectChange;
struct PlaceChange;

// joining
struct MergedMaps;

// figures
struct CloudLayer;
struct CloudView;
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
class ReplaySource;

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

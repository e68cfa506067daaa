// World mapper: keeps areas and objects beside the places of a map while its frames come.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/odometry/rgbd.hpp"
#include "estancia/session/session.hpp"

namespace estancia {

struct AreaEdit;
class KnownObjects;
class Labeler;
struct ObjectEdit;
class ObjectModel;
struct Observation;
class Sequence;
struct WantedWorld;
struct WorldLayers;
struct WorldMap;
struct WorldOptions;

/// The most frames that zones are found of with the map; more take `estancia zones find MAP --stream`.
constexpr std::size_t maxFramesOfZones = 5000;

/// The camera of a drive that a map has to track by itself: it has depth, and no frame has a pose. Nothing
/// for other drives, and where neither areas nor objects are wanted.
std::optional<CameraIntrinsics> cameraToTrack(const Sequence& drive, const WorldOptions& options);

/// How a map that tracks its camera itself was leveled.
struct MapLevel {
  /// Leveled by floor, tables, ceiling and walls; else by the cameras, which are assumed upright.
  bool byPlanes = false;
  /// Tilt of the first camera [degrees].
  double tilt = 0;
};

/// A camera that is suddenly elsewhere.
struct PoseJump {
  /// Names of frames.
  std::string from, to;
  /// [m]
  double distance = 0;
  /// [s]; nothing without time stamps.
  std::optional<double> seconds;
};

/// Faults of the frames that were observed.
struct DriveFaults {
  struct Frames {
    std::size_t count = 0;
    /// The name of the first one.
    std::string first;
  };
  std::size_t depthImages = 0;
  /// Depth images without a value, and with none below 65.5 m. They show nothing.
  Frames noDepth, tooFar;
  /// Poses that moved twenty times as far as usual, and more than 1 m, faster than 5 m/s; without time
  /// stamps, more than 10 m. And the first three.
  std::size_t jumps = 0;
  std::vector<PoseJump> named;
  /// Frames that were left out of areas and objects: those after a jump, until three in a row agree.
  std::size_t doubted = 0;
};

/// The space that a frame shows is stored as an observation; areas and objects are a function of the
/// observations and of the frames' poses. So they can be made again when the poses are corrected or the map
/// is continued, and they never disagree.
///
/// Where frames have no poses, the camera is tracked while they come, by RGB-D odometry. A loop closure moves
/// the frames that it corrects at once. When the number of views has grown by half or by a third, and in
/// finish(), the map is leveled by the planes that were seen, so that z is up, and what was seen is moved,
/// too.
class WorldMapper {
 public:
  /// The options that the session's map was made with; nothing of a new map, and of one of older programs.
  static std::optional<WorldOptions> optionsOf(MappingSession& session);
  /// A sentence for each option that the session's map was made with and that has another, fixed value now.
  static std::vector<std::string> goneOptionsOf(MappingSession& session);

  /// Goes on with the layers of the session's map, if it has any. `change` changes the options of the map, or
  /// of a new one the defaults (declare(WorldOptions&) in map_sequence.hpp sets them by name); the map keeps
  /// them, but the number of threads. `labeler` names objects by images
  /// of them; without one, or with one that needs no images, they have no words. Both must outlive it. Throws
  /// Error: invalidOption, corruptFile, and mismatch when other layers or options are wanted than the map
  /// has. `track`: the camera of images and depth, in any size, whose poses are to be tracked: those of the
  /// frames are not looked at. Throws Error: mismatch when the map's poses come from elsewhere, or were
  /// tracked with other options or another camera; missingDependency without estancia-odometry. A map whose
  /// frames have no poses, and were not tracked, stays so.
  explicit WorldMapper(MappingSession& session, Labeler* labeler = nullptr,
                       const std::optional<CameraIntrinsics>& track = {},
                       const std::function<void(WorldOptions&)>& change = {});
  /// With these options (world_options.hpp).
  WorldMapper(MappingSession& session, const WantedWorld& options, Labeler* labeler = nullptr,
              const std::optional<CameraIntrinsics>& track = {});
  WorldMapper(WorldMapper&&) noexcept;
  ~WorldMapper();

  /// After the session's.
  void beginDrive();
  /// The camera of the drive's depth images, and Sequence::depthScale(). Throws Error (mismatch) when those
  /// of earlier runs were others.
  void keepCamera(const CameraIntrinsics& camera, double depthScale);

  /// Takes the frame that is added to the session next: its image (BGR, may be empty), and its depth: CV_32F
  /// [m], 0 where unknown, empty where there is none; `camera` has images of any size. Returns the pose to
  /// add it with: the frame's own, or as it was tracked, as far as it is known. A frame without depth or
  /// pose, or from where the robot has just looked, adds nothing to the layers. Throws Error (invalidInput;
  /// mismatch, also when the map has tracked its camera so far and is not to track this one).
  std::optional<Pose> observe(const Frame& frame, DescriptorView descriptor, const cv::Mat& image,
                              const cv::Mat& depth, const CameraIntrinsics& camera);
  /// Adds a frame of another map, with its stored observation.
  void observe(const Frame& frame, DescriptorView descriptor, std::optional<Observation> seen);
  /// The map with its layers, as it would be read from its file.
  WorldMap read();
  /// Called with a frame's place (node id) and pose.
  using Placed = std::function<void(int place, const std::optional<Pose>& pose)>;
  /// Does both: adds the frame to the session, with `thumbnail`, and reports where it is before it updates
  /// the layers with it, which takes longer. For robots that wait for the place. Where a `deadline` is given,
  /// what would end later is left to the next frames: the view, or some labels of its objects.
  void add(const Frame& frame, DescriptorView descriptor, const cv::Mat& image, const cv::Mat& depth,
           const CameraIntrinsics& camera, const MappingSession::Image& thumbnail, const Placed& placed,
           const std::optional<std::chrono::steady_clock::time_point>& deadline = {});
  /// The layers of the map.
  const WorldLayers& layers() const;
  /// Whether the camera of the frames is tracked.
  bool tracks() const;
  /// Whether it wants the image of a frame with depth: to track the camera, or to name and color objects.
  bool wantsImage(const Frame& frame) const;
  /// Looks for these in finish(), also in what was mapped before: their names and poses are added to the
  /// objects that they are. Where the map has no objects, none is found.
  void recognize(std::shared_ptr<const KnownObjects> objects);
  /// Classifies objects with a trained model of shapes: its classes are added to the objects, not to flat
  /// ones. Results of an earlier model are dropped. `digest`: of the model's file.
  void classify(const ObjectModel& model, const std::string& digest);
  /// Derives the layers and writes them, after the session's finish(). More frames may follow.
  void finish();
  /// Areas and objects as of one moment; only the mapper that they are of can read them.
  struct Derived;
  using Derivation = std::function<std::shared_ptr<const Derived>()>;
  /// The work of deriving them as of now. Another thread may do it while frames come: it has copies.
  Derivation derivation() const;
  /// Writes what was derived, with all frames so far. Unlike finish() it settles nothing where the camera is
  /// tracked, and leaves zones as they are. Returns whether it did: what was derived before an edit or
  /// another leveling is no longer true.
  bool refresh(const Derived& derived);
  /// Applies a person's edits of areas and objects to the map as of now; they are kept, and written with all
  /// frames. Throws Error (invalidInput) for a split that cuts nothing, and insufficientData where there are
  /// no areas yet.
  void edit(const AreaEdit& edit);
  void edit(const ObjectEdit& edit);

  /// How the camera was tracked, after finish(); nothing where it was not.
  const std::optional<RgbdTrajectory>& odometry() const;
  /// How that map was leveled.
  const std::optional<MapLevel>& level() const;

  const DriveFaults& faults() const;

  /// Views that were so far from the others that no floor plan holds them: an error of the poses, mostly.
  std::size_t viewsTooFar() const;

 private:
  static WantedWorld changedOptions(MappingSession& session,
                                    const std::function<void(WorldOptions&)>& change);
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace estancia

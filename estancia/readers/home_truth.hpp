// Home truth: the things of a furnished home, what each frame sees of them, and the room that it sees.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "estancia/core/camera.hpp"
#include "estancia/core/pose.hpp"
#include "estancia/files/home_plan.hpp"
#include "estancia/sequences/sequence.hpp"

namespace estancia::io {

/// The pixels of an instance mask that show no instance have these values.
enum class Structure : std::uint16_t { outside, floor, wall, ceiling, doorOrWindowFrame, ceilingLamp };

/// The ids of instances are this or above.
constexpr int firstInstance = 10;

/// A thing in the home: a box that stands upright.
struct HomeInstance {
  /// Instance number: equal in all drives of a home; value of its pixels in instance masks.
  int id = 0;
  std::string category, model, modelName;
  /// The room that it stands in; "" where unknown.
  std::string room;
  /// Middle of the box, and its size before it is turned [m].
  cv::Point3d center, size;
  /// Turn about z, counter-clockwise [rad]; at 0 its front looks to −y.
  double yaw = 0;
  /// The name under which a drive moves it; "" for most.
  std::string movableName;
};

/// Visible part of an instance in a frame.
struct VisibleInstance {
  int id = 0;
  int pixels = 0;
  /// Number of its pixels that have a depth.
  int pixelsWithDepth = 0;
};
/// By the file name of the image.
using VisibleByImage = std::map<std::string, std::vector<VisibleInstance>>;

/// Reads the CSV `id,category,model,model_name,room,x,y,z,size_x,size_y,size_z,yaw_degrees,movable_name`
/// (columns in any order, the last may be missing). Throws Error (malformedFile, naming file and line): a
/// column or cell is missing, an id is below 10, above 65535 or there twice, a number is not finite or beyond
/// 10 km, a size is negative.
std::vector<HomeInstance> readHomeInstances(const std::filesystem::path& file);

/// Reads the CSV `image,id,pixels,pixels_with_depth`. Throws Error (malformedFile, naming file and line): an
/// id that no instance has, an instance twice in an image, counts that are no counts of pixels.
VisibleByImage readVisibleInstances(const std::filesystem::path& file,
                                    const std::vector<HomeInstance>& instances);

/// Reads an instance mask: CV_16U, never empty; a pixel holds the id of its instance, or a Structure. Throws
/// Error when the file cannot be read, or is no image of one channel with 16 bits.
cv::Mat readInstanceMask(const std::filesystem::path& file);

/// The mask of a frame in the folder of a drive: instance/NAME.png. It need not exist.
std::filesystem::path instanceMaskFile(const std::filesystem::path& folder, const Frame& frame);

/// The truth about a drive.
struct HomeTruth {
  HomePlan plan;
  /// Both empty where the folder lacks the files.
  std::vector<HomeInstance> instances;
  VisibleByImage visible;
};

/// Whether a folder has a home.json.
bool hasHomeTruth(const std::filesystem::path& folder);

/// Reads home.json and, where they are there, instances.csv and visible.csv of a folder. Throws Error as the
/// readers do, and where there is visible.csv without instances.csv.
HomeTruth readHomeTruth(const std::filesystem::path& folder);

/// The room that most of the depth image lies in: its surfaces are put into the plan by the pose
/// (T_map_camera). About 5,000 pixels, evenly spread, are looked at. Absent when none of them lies in a room.
/// `depth` is CV_32F [m], 0 where unknown, else Error (invalidInput); `camera` may have another size.
std::optional<std::size_t> roomSeen(const HomePlan& plan, const cv::Mat& depth,
                                    const CameraIntrinsics& camera, const Pose& pose);

/// The name of the room that most of the visible instances' pixels stand in; "" when there are none.
std::string roomSeen(const std::vector<VisibleInstance>& visible, const std::vector<HomeInstance>& instances);

/// The room that each frame of a sequence sees: by depth and pose, else by visible.csv, else "". A frame
/// whose depth cannot be read counts as one without depth. O(frames); reads all depth images.
std::vector<std::string> roomsSeen(const HomeTruth& truth, const Sequence& sequence);

/// The frames of a drive that have these images, by their file names. `folder` names it in errors. Throws
/// Error (mismatch): an image is not in it, or two in `images` have one name.
std::vector<std::size_t> framesOfImages(const Sequence& drive, const std::filesystem::path& folder,
                                        const std::vector<std::string>& images);

/// The rooms that images of the drive in `folder` see, as above, by their file names. Throws Error: the
/// folder cannot be read, or an image is not in it, or two in `images` have one name (mismatch).
std::vector<std::string> roomsSeen(const std::filesystem::path& folder,
                                   const std::vector<std::string>& images);

}  // namespace estancia::io

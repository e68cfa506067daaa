// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/error.hpp"
#include "estancia/files/camera_file.hpp"
#include "estancia/files/cloud_file.hpp"
#include "estancia/files/csv.hpp"
#include "estancia/files/depth_file.hpp"
#include "estancia/files/frame_list.hpp"
#include "estancia/files/home_plan.hpp"
#include "estancia/files/image_decoding.hpp"
#include "estancia/files/image_file.hpp"
#include "estancia/files/label_scores.hpp"
#include "estancia/files/ply.hpp"
#include "estancia/readers/home_truth.hpp"
#include "estancia/readers/message_image.hpp"
#include "estancia/readers/object_samples.hpp"
#include "estancia/sequences/descriptor_sequence.hpp"
#include "estancia/sequences/feature_table.hpp"
#include "estancia/sequences/trajectory.hpp"
#include "fuzz/fuzz_target.hpp"

namespace estancia::fuzz {

using namespace io;

// Clouds

FUZZ_TARGET(io, pcd) {
  readCloud(inputFile("input.pcd", bytes));
}

FUZZ_TARGET(io, ply) {
  const std::filesystem::path file = inputFile("input.ply", bytes);
  readCloud(file);
  readPlyMesh(file);
}

// Images

FUZZ_TARGET(io, image_header) {
  inspectImage(bytes, "input.png");
}

/// Larger ones are decoded, too, but one would wait for OpenCV alone.
FUZZ_TARGET(io, image) {
  const ImageHeader header = inspectImage(bytes, "input.png");
  if (header.width * header.height > 1 << 16) return;
  const std::filesystem::path file = inputFile("input.png", bytes);
  readImage(file);
  readReducedImage(file, 16);
}

FUZZ_TARGET(io, panorama) {
  readPanorama(inputFile("input.js", bytes));
}

FUZZ_TARGET(io, depth) {
  const ImageHeader header = inspectImage(bytes, "input.png");
  if (header.width * header.height > 1 << 16) return;
  readDepth(inputFile("input.png", bytes), 1000);
}

/// Decodes small messages only: others cost time without covering more.
static void decodeMessage(const ros::SerializedMessage& message, unsigned kind) {
  const auto isSmall = [](const auto& read) { return std::uint64_t{read.width} * read.height <= 1 << 16; };
  if (kind == 0) {
    const ros::ImageMessage image = ros::readImageMessage(message);
    if (isSmall(image)) contentOf(image) == ImageContent::depth ? depthOf(image, 1000) : imageOf(image);
  } else if (kind == 1) {
    const ros::PointCloudMessage cloud = ros::readPointCloud(message);
    if (isSmall(cloud)) depthOf(cloud);
  } else {
    const ros::CompressedImageMessage image = ros::readCompressedImage(message);
    contentOf(image) == ImageContent::depth ? depthOf(image, 1000) : imageOf(image);
  }
}

/// The first byte chooses encoding and kind: images, clouds, compressed images.
FUZZ_TARGET(io, message) {
  if (bytes.empty()) return;
  const auto choice = static_cast<unsigned char>(bytes.front());
  decodeMessage({std::as_bytes(std::span(bytes.substr(1))),
                 (choice & 1) != 0 ? ros::Encoding::cdr : ros::Encoding::ros1},
                (choice >> 1) % 3U);
}

// Labels and features

FUZZ_TARGET(io, npy) {
  const auto files = parts(bytes, 3);
  const DescriptorFileOptions options{inputFile("labels.txt", files[0]), inputFile("frames.csv", files[1])};
  readDescriptors(inputFile("input.npy", files[2]), options);
}

FUZZ_TARGET(io, label_file) {
  readDescriptors(inputFile("input.labels", bytes));
}

FUZZ_TARGET(io, label_csv) {
  readDescriptors(inputFile("input.csv", bytes));
}

FUZZ_TARGET(io, label_json_lines) {
  readDescriptors(inputFile("input.jsonl", bytes));
}

FUZZ_TARGET(io, label_answer) {
  const auto texts = parts(bytes, 2);
  requireJsonPointer(std::string(texts[0]), "input");
  readAnswer(texts[1], {.at = std::string(texts[0])}, "input");
}

FUZZ_TARGET(io, csv) {
  readCsv(inputFile("input.csv", bytes));
}

FUZZ_TARGET(io, feature_table) {
  readFeatureTable(inputFile("input.csv", bytes));
}

// What lies beside images

FUZZ_TARGET(io, frame_list) {
  readFrameList(inputFile("input.csv", bytes));
}

FUZZ_TARGET(io, trajectory) {
  readTrajectory(inputFile("poses.txt", bytes));
}

FUZZ_TARGET(io, intrinsics) {
  readIntrinsics(inputFile("intrinsics.txt", bytes));
}

FUZZ_TARGET(io, home_plan) {
  readHomePlan(inputFile("home.json", bytes));
}

FUZZ_TARGET(io, home_truth) {
  const auto files = parts(bytes, 2);
  const std::vector<HomeInstance> instances = readHomeInstances(inputFile("instances.csv", files[0]));
  readVisibleInstances(inputFile("visible.csv", files[1]), instances);
}

FUZZ_TARGET(io, object_samples) {
  inputFile("samples.csv", bytes);
  readObjectSamples(folder());
}

}  // namespace estancia::fuzz

// Object samples: the folder of `estancia objects collect`, samples.csv with an image and a cloud per sample.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "estancia/readers/object_views.hpp"

namespace estancia {

/// DIR/samples.csv begins with the line `# estancia object samples 1`, then
/// `name,instance,category,split,frame,x,y,width,height,flat,at_border`. DIR/images/NAME.png is a crop around
/// the object, whose bounding box in it is x, y, width, height; DIR/masks/NAME.png (optional) has the size of
/// the crop and is not 0 on the object; DIR/clouds/NAME.pcd holds its points; DIR/words.labels (optional) the
/// labels of a labeler for the images. Names are plain file names.
struct ObjectSample {
  ObjectView view;
  cv::Rect box;
};

/// Throws Error `FILE:LINE: …` on anything else, on names that leave the folder and on repeated names.
std::vector<ObjectSample> readObjectSamples(const std::filesystem::path& folder);

/// Writes samples.csv, whole or not at all; the caller writes images and clouds.
void writeObjectSamples(const std::vector<ObjectSample>& samples, const std::filesystem::path& folder);

bool isObjectSamples(const std::filesystem::path& folder);
std::filesystem::path imageOf(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path maskOf(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path cloudOf(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path labelFileOf(const std::filesystem::path& folder);

}  // namespace estancia

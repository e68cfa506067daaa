// The folder that `estancia objects collect` fills: samples.csv, and of each sample an image and a cloud.
#pragma once

#include <filesystem>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "estancia/io/object_views.hpp"

namespace estancia {

/// DIR/samples.csv begins with the line `# estancia object samples 1`, then
/// `name,instance,category,split,frame,x,y,width,height,flat,at_border`; DIR/images/NAME.png is a
/// image of the thing and what is around it, in which it has the box x, y, width, height;
/// DIR/masks/NAME.png, where it is there, is of its size and not 0 on the thing; DIR/clouds/NAME.pcd are its
/// points; DIR/words.labels, where it is there, the words of a labeler for the images. Names are plain file
/// names.
struct ObjectSample {
  ObjectView view;
  cv::Rect box;
};

/// Throws Error `file:line: …` on anything else, names that leave the folder, and names that stand there
/// twice.
std::vector<ObjectSample> readObjectSamples(const std::filesystem::path& folder);

/// Writes samples.csv whole; images and clouds are the caller's.
void writeObjectSamples(const std::filesystem::path& folder, const std::vector<ObjectSample>& samples);

bool isObjectSamples(const std::filesystem::path& folder);
std::filesystem::path imageOf(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path maskOf(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path cloudOf(const std::filesystem::path& folder, const std::string& name);
std::filesystem::path wordsOf(const std::filesystem::path& folder);

}  // namespace estancia

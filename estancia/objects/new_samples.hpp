// A folder of samples in the making: there whole or not at all.
#pragma once

#include <filesystem>
#include <vector>

#include "estancia/io/object_samples.hpp"

namespace estancia {

/// Fills FOLDER.part, which takes the place of FOLDER when it is finished; until then what is there stays.
class NewSamples {
 public:
  /// Throws Error when there is no name; when FOLDER is there and not empty, unless it is to be replaced and
  /// holds samples and nothing else; and when FOLDER.part cannot be made, or is there and not what a killed
  /// run left.
  NewSamples(const std::filesystem::path& folder, bool replace);

  /// Removes FOLDER.part unless it was finished.
  ~NewSamples();
  NewSamples(const NewSamples&) = delete;
  NewSamples& operator=(const NewSamples&) = delete;

  /// Where images, masks and clouds go for now.
  const std::filesystem::path& folder() const { return part_; }

  /// Writes the list and puts the folder in its place. Throws Error when that fails.
  void finish(const std::vector<ObjectSample>& samples);

 private:
  NewSamples() = default;

  std::filesystem::path folder_, part_;
};

}  // namespace estancia

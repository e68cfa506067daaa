// New sample folder: written beside its place, then renamed.
#pragma once

#include <filesystem>
#include <vector>

#include "estancia/io/object_samples.hpp"

namespace estancia {

/// Fills FOLDER.part, which replaces FOLDER when it is finished.
class NewSamples {
 public:
  /// Throws Error without a name (invalidOption); when FOLDER exists and is not empty, unless it is to be
  /// replaced and has samples only (fileExists); and when FOLDER.part cannot be made (fileUnwritable), or
  /// exists and is not that of a killed run (fileExists).
  NewSamples(const std::filesystem::path& folder, bool replace);

  /// Removes FOLDER.part unless it was finished.
  ~NewSamples();
  NewSamples(const NewSamples&) = delete;
  NewSamples& operator=(const NewSamples&) = delete;

  /// The folder of images, masks and clouds until finish().
  const std::filesystem::path& folder() const { return part_; }

  /// Writes the list and renames the folder. Throws Error (fileUnwritable).
  void finish(const std::vector<ObjectSample>& samples);

 private:
  NewSamples() = default;

  std::filesystem::path folder_, part_;
};

}  // namespace estancia

// Temporary folder: readable by this user only, removed at the end, after a crash by the next run.
#pragma once

#include <filesystem>

namespace estancia {

/// A folder `estancia-XXXXXX` in the temporary folder ($TMPDIR, else /tmp). Its owner holds a lock on a file
/// in it (flock(2)), which the kernel releases however the owner ends.
class PrivateFolder {
 public:
  /// Removes those that killed processes of this user have left, then makes one. Throws Error.
  PrivateFolder();
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

}  // namespace estancia

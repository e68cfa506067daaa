// SPDX-License-Identifier: Apache-2.0
#include "estancia/live/file_stamp.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

namespace estancia {

std::string fileStamp(const std::filesystem::path& path) {
  std::string stamp;
  for (const char* ending : {"", "-wal"}) {
    struct stat file {};
    if (stat((path.string() + ending).c_str(), &file) != 0 || file.st_size == 0) continue;
    stamp +=
        fmt::format("{} {} {}.{};", file.st_ino, file.st_size, file.st_mtim.tv_sec, file.st_mtim.tv_nsec);
  }
  return stamp;
}

}  // namespace estancia

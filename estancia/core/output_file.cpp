#include "estancia/core/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "estancia/core/error.hpp"

namespace estancia {

void writeWhole(const std::filesystem::path& path, std::string_view bytes) {
  if (std::filesystem::is_directory(path))
    throw Error(fmt::format("{}: a folder; give the name of a file to write", path.string()));
  auto beside = path;
  beside.replace_filename(fmt::format(".{}.{}.part", path.filename().string(), getpid()));
  std::ofstream file(beside, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code problem;
  if (file)
    std::filesystem::rename(beside, path, problem);
  else
    problem = std::error_code(errno, std::generic_category());
  if (!problem) return;
  std::error_code ignored;
  std::filesystem::remove(beside, ignored);
  throw Error(fmt::format("{}: cannot be written ({}); check the folder and the room on the disk",
                          path.string(), problem.message()));
}

}  // namespace estancia

// SPDX-License-Identifier: Apache-2.0
#include "estancia/core/output_file.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "estancia/core/fail.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

const char* nameOf(fs::file_type type) {
  switch (type) {
    case fs::file_type::directory:
      return "folder";
    case fs::file_type::fifo:
      return "pipe";
    case fs::file_type::socket:
      return "socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "device";
    default:
      return "special file";
  }
}

}  // namespace

fs::path outputTarget(const fs::path& path) {
  constexpr int maxLinks = 40;  // as the kernel follows
  std::error_code problem;
  const auto type = fs::status(path, problem).type();  // asks the kernel: links of /proc lead nowhere else
  if (type != fs::file_type::regular && type != fs::file_type::not_found && type != fs::file_type::none)
    fail(ErrorCode::fileUnwritable, "{} is a {}; give the name of a file to write", path.string(),
         nameOf(type));
  fs::path target = path;
  for (int links = 0; fs::is_symlink(target, problem); ++links) {
    if (links == maxLinks)
      fail(ErrorCode::fileUnwritable, "{} is a circular link; give another name", path.string());
    const fs::path next = fs::read_symlink(target, problem);
    if (problem)
      fail(ErrorCode::fileUnwritable, "{} is a link that cannot be read ({}); give another name",
           path.string(), problem.message());
    target = target.parent_path() / next;
  }
  return target;
}

void writeWhole(const fs::path& path, std::string_view bytes) {
  const fs::path target = outputTarget(path);
  auto beside = target;
  beside.replace_filename(fmt::format(".{}.{}.part", target.filename().string(), getpid()));
  std::ofstream file(beside, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code problem;
  if (file)
    fs::rename(beside, target, problem);
  else
    problem = std::error_code(errno, std::generic_category());
  if (!problem) return;
  std::error_code ignored;
  fs::remove(beside, ignored);
  fail(ErrorCode::fileUnwritable, "{} cannot be written ({}); check the folder and the free disk space",
       path.string(), problem.message());
}

}  // namespace estancia

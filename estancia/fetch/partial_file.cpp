// SPDX-License-Identifier: Apache-2.0
#include "estancia/fetch/partial_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"

namespace estancia {
namespace fs = std::filesystem;
namespace {

std::string because() {
  return std::generic_category().message(errno);
}

}  // namespace

PartialFile::PartialFile(fs::path target)
    : target_(std::move(target)), part_(target_.string() + ".part"), from_(part_.string() + ".from") {
  std::error_code problem;
  fs::create_directories(target_.parent_path(), problem);
  file_ = open(part_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (problem || file_ < 0)
    fail(ErrorCode::fileUnwritable, "{}: cannot be written ({}); check the folder and its permissions",
         part_.string(), problem ? problem.message() : because());
  struct stat opened {
  }, named{};
  // A file that was finished between opening and locking has another name by now.
  if (flock(file_, LOCK_EX | LOCK_NB) != 0 || fstat(file_, &opened) != 0 ||
      stat(part_.c_str(), &named) != 0 || opened.st_ino != named.st_ino) {
    close(file_);
    fail(ErrorCode::busy, "{} is being fetched by another process; wait for it", target_.string());
  }
  size_ = static_cast<std::uint64_t>(opened.st_size);
  std::ifstream from(from_);
  std::getline(from, source_);
  std::getline(from, version_);
}

PartialFile::~PartialFile() {
  std::error_code ignored;
  if (size_ == 0) {  // nothing that one could go on with
    fs::remove(part_, ignored);
    fs::remove(from_, ignored);
  }
  close(file_);
}

void PartialFile::restart(const std::string& source, const std::string& version) {
  if (ftruncate(file_, 0) != 0)
    fail(ErrorCode::fileUnwritable, "{}: cannot be emptied ({})", part_.string(), because());
  size_ = 0;
  source_ = source;
  version_ = version;
  writeWhole(from_, source_ + "\n" + version_ + "\n");
}

void PartialFile::append(std::string_view bytes) {
  while (!bytes.empty()) {
    const auto written = pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0)
      fail(ErrorCode::fileUnwritable,
           "{}: cannot be written any further ({}); make room on the disk and run this again", part_.string(),
           because());
    size_ += static_cast<std::uint64_t>(written);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void PartialFile::finish() {
  std::error_code problem;
  fs::rename(part_, target_, problem);
  if (problem)
    fail(ErrorCode::fileUnwritable, "{}: cannot be written ({})", target_.string(), problem.message());
  std::error_code ignored;
  fs::remove(from_, ignored);
}

}  // namespace estancia

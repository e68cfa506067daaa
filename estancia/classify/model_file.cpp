// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/model_file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "estancia/core/digest.hpp"
#include "estancia/core/fail.hpp"
#include "estancia/core/output_file.hpp"
#include "estancia/files/files.hpp"

namespace estancia {
namespace fs = std::filesystem;

void writeModelFile(const fs::path& file, const ModelFileKind& kind, std::string_view content) {
  ByteWriter out;
  out.raw(kind.magic);
  out.number(kind.version);
  out.raw(sha256(content));
  out.raw(content);
  writeWhole(file, out.bytes());
}

ModelFileReader::ModelFileReader(const fs::path& file, const ModelFileKind& kind)
    : bytes_(io::readBytes(file, std::size_t{64} << 30)),
      in_(bytes_, io::printable(file.string()), fmt::format("train the {} again", kind.noun)) {
  const std::string name = io::printable(file.string());
  if (!bytes_.starts_with(kind.magic))
    fail(ErrorCode::unsupportedFile, "{} is not a {}; give one that `{}` has written", name, kind.noun,
         kind.command);
  in_.raw(kind.magic.size());
  if (const auto found = in_.number<std::uint32_t>(); found != kind.version)
    fail(ErrorCode::unsupportedFile,
         "{}: this {} has version {}, this program reads version {}; train it again or update Estancia", name,
         kind.noun, found, kind.version);
  const std::string digest(in_.raw(64));  // hex digits of a SHA-256
  if (sha256(std::string_view(bytes_).substr(bytes_.size() - in_.remaining())) != digest)
    in_.fail("it is damaged (its digest differs)", ErrorCode::corruptFile);
}

void ModelFileReader::requirePrintable(const std::vector<std::string>& texts) const {
  for (const std::string& text : texts)
    if (io::printable(text) != text) in_.fail("a name has control characters or is not UTF-8");
}

std::pair<FeatureEmbedding, std::shared_ptr<const Classifier>> ModelFileReader::classifier(
    std::size_t classes) {
  FeatureEmbedding embedding = FeatureEmbedding::read(in_);
  std::shared_ptr<const Classifier> classifier = readClassifier(in_);
  requirePrintable({classifier->choice()});
  for (const PartEmbedding& learned : embedding.parts())
    requirePrintable({learned.part.name, learned.part.identity});
  if (in_.remaining() != 0 || static_cast<std::size_t>(classifier->classCount()) != classes ||
      classifier->columns() != embedding.columns())
    in_.fail("it is damaged (its names, parts and classifier do not fit)");
  return {std::move(embedding), std::move(classifier)};
}

bool isModelFile(const fs::path& file, const ModelFileKind& kind) {
  std::string start(kind.magic.size(), ' ');
  std::error_code none;
  if (fs::is_regular_file(file, none))
    std::ifstream(file, std::ios::binary).read(start.data(), static_cast<std::streamsize>(start.size()));
  return start == kind.magic;
}

}  // namespace estancia

// SPDX-License-Identifier: Apache-2.0
#include "estancia/files/image_decoding.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "estancia/core/fail.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {
namespace {

constexpr std::uint64_t maxPixels = std::uint64_t{1} << 26;

struct CutOff {};   // the data is truncated
struct Damaged {};  // the header is invalid

/// Numbers from bytes; reading beyond the end means that the file is truncated.
struct Bytes {
  std::string_view data;

  void need(std::uint64_t end) const {
    if (end > data.size()) throw CutOff();
  }
  std::uint64_t big(std::uint64_t at, unsigned count) const {
    need(at + count);
    std::uint64_t value = 0;
    for (unsigned i = 0; i < count; ++i) value = value << 8 | static_cast<unsigned char>(data[at + i]);
    return value;
  }
  std::uint64_t little(std::uint64_t at, unsigned count) const {
    need(at + count);
    std::uint64_t value = 0;
    for (unsigned i = count; i-- > 0;) value = value << 8 | static_cast<unsigned char>(data[at + i]);
    return value;
  }
  std::int64_t littleSigned32(std::uint64_t at) const {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(little(at, 4)));
  }
  /// The text from `at` up to one of `ends`, behind which `at` is then.
  std::string_view takeUntil(std::string_view ends, std::uint64_t& at) const {
    const auto end = data.find_first_of(ends, at);
    if (end == std::string_view::npos) throw CutOff();
    const auto text = data.substr(at, end - at);
    at = end + 1;
    return text;
  }
  bool startsWith(std::string_view magic) const { return data.starts_with(magic); }
};

using Size = ImageHeader;

/// Walks the markers up to end-of-image, also in entropy-coded data, where every FF is stuffed.
Size inspectJpeg(const Bytes& b) {
  Size size{"JPEG"};
  bool framed = false;
  std::uint64_t at = 2;
  for (;;) {
    at = std::min<std::uint64_t>(b.data.find('\xFF', at), b.data.size());
    while (b.big(at, 1) == 0xFF) ++at;
    const auto marker = b.big(at++, 1);
    if (marker == 0xD9) return size;
    if (marker <= 0x01 || (marker >= 0xD0 && marker <= 0xD8))
      continue;  // stuffed byte, restart: no length follows
    const auto length = b.big(at, 2);
    const bool isFrame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (isFrame && !framed) {  // decoders go by the first one, too
      framed = true;
      size.height = b.big(at + 3, 2);
      size.width = b.big(at + 5, 2);
    }
    at += std::max<std::uint64_t>(length, 2);
  }
}

Size inspectPng(const Bytes& b) {
  Size size{"PNG", b.big(16, 4), b.big(20, 4)};
  for (std::uint64_t at = 8;;) {
    const auto length = b.big(at, 4);
    b.need(at + 12 + length);
    if (b.data.substr(at + 4, 4) == "IEND") return size;
    at += 12 + length;
  }
}

Size inspectBmp(const Bytes& b) {
  const auto pixels = b.little(10, 4), headerSize = b.little(14, 4);
  if (headerSize == 12) return {"BMP", b.little(18, 2), b.little(20, 2)};  // OS/2
  const auto width = b.littleSigned32(18),
             height = b.littleSigned32(22);  // top-down images count downwards
  const auto bits = b.little(28, 2), compression = b.little(30, 4);
  if (width <= 0 || height == 0) throw Damaged();
  Size size{"BMP", static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(std::abs(height))};
  const bool plain = compression == 0 || compression == 3;
  if (plain && size.width * size.height <= maxPixels)
    b.need(pixels + (size.width * bits + 31) / 32 * 4 * size.height);
  return size;
}

/// The first directory: the size, and that every strip or tile lies inside the file.
Size inspectTiff(const Bytes& b) {
  const bool bigEndian = b.startsWith("MM");
  const auto number = [&](std::uint64_t at, unsigned n) {
    return bigEndian ? b.big(at, n) : b.little(at, n);
  };
  const bool bigTiff = number(2, 2) == 43;
  const unsigned word = bigTiff ? 8 : 4;
  const auto directory = bigTiff ? number(8, 8) : number(4, 4);
  if (directory > b.data.size()) throw CutOff();
  const auto entries = number(directory, bigTiff ? 8 : 2);
  const unsigned entrySize = bigTiff ? 20 : 12;
  if (entries > b.data.size() / entrySize) throw CutOff();

  struct Array {
    std::uint64_t at = 0, count = 0;
    unsigned width = 0;
  };
  Array offsets, lengths;
  std::set<std::uint64_t> tags;
  Size size{"TIFF"};
  for (std::uint64_t e = 0; e < entries; ++e) {
    const auto at = directory + (bigTiff ? 8 : 2) + e * entrySize;
    const auto tag = number(at, 2), type = number(at + 2, 2), count = number(at + 4, word);
    if (!tags.insert(tag).second) continue;  // libtiff takes the first of several
    const unsigned width = type == 3 ? 2 : type == 4 ? 4 : type == 16 ? 8 : 0;
    if (width == 0) continue;
    if (count > b.data.size()) throw CutOff();
    const auto field = at + 4 + word;
    const Array values{count * width <= word ? field : number(field, word), count, width};
    if (values.at > b.data.size()) throw CutOff();
    if (tag == 256) size.width = number(values.at, width);
    if (tag == 257) size.height = number(values.at, width);
    if (tag == 273 || tag == 324) offsets = values;
    if (tag == 279 || tag == 325) lengths = values;
  }
  for (std::uint64_t i = 0; i < std::min(offsets.count, lengths.count); ++i) {
    const auto offset = number(offsets.at + i * offsets.width, offsets.width);
    if (offset > b.data.size()) throw CutOff();
    b.need(offset + number(lengths.at + i * lengths.width, lengths.width) % (std::uint64_t{1} << 62));
  }
  return size;
}

/// Follows libwebp's WebPGetFeatures() on the 32 bytes that OpenCV recognizes WebP by (RFC 9649, 6386).
Size inspectWebp(const Bytes& b) {
  constexpr std::uint64_t beforeChunk = 12;  // bytes
  const std::uint64_t riff = b.little(4, 4);
  b.need(std::max<std::uint64_t>(8 + riff, 32));
  const std::string_view kind = b.data.substr(12, 4);
  const std::uint64_t size = b.little(16, 4);
  if (riff < beforeChunk) throw Damaged();
  if (kind == "VP8X" && size == 10) return {"WebP", b.little(24, 3) + 1, b.little(27, 3) + 1};
  if (size > riff - beforeChunk) throw Damaged();
  const std::uint64_t bits = b.little(20, 4);
  if (kind == "VP8 ") {
    const bool isShownKeyFrame = (bits & 1) == 0 && (bits >> 1 & 7) <= 3 && (bits >> 4 & 1) == 1;
    if (!isShownKeyFrame || (bits & 0xFFFFFF) >> 5 >= size || b.data.substr(23, 3) != "\x9D\x01\x2A")
      throw Damaged();
    return {"WebP", b.little(26, 2) & 0x3FFF, b.little(28, 2) & 0x3FFF};
  }
  if (kind == "VP8L" && (bits & 0xFF) == 0x2F && b.little(24, 1) >> 5 == 0)
    return {"WebP", (b.little(21, 4) & 0x3FFF) + 1, (b.little(21, 4) >> 14 & 0x3FFF) + 1};
  throw Damaged();
}

Size inspectPnm(const Bytes& b) {
  const char kind = b.data[1];
  std::uint64_t at = 2;
  const auto next = [&]() -> std::uint64_t {
    for (;; ++at) {  // blanks and comments
      if (b.big(at, 1) == '#') at = std::min<std::uint64_t>(b.data.find('\n', at), b.data.size());
      if (const auto c = b.big(at, 1); c >= '0' && c <= '9') break;
    }
    std::uint64_t value = 0;
    for (; at < b.data.size() && b.data[at] >= '0' && b.data[at] <= '9'; ++at) {
      value = value * 10 + static_cast<std::uint64_t>(b.data[at] - '0');
      if (value > 1'000'000'000) throw Damaged();
    }
    return value;
  };
  Size size{"PNM", next(), 0};
  size.height = next();
  const std::uint64_t bytesPerValue = kind == '1' || kind == '4' ? 0 : next() > 255 ? 2 : 1;
  if (size.width * size.height > maxPixels) return size;
  if (kind == '4') b.need(at + 1 + (size.width + 7) / 8 * size.height);
  if (kind == '5') b.need(at + 1 + size.width * size.height * bytesPerValue);
  if (kind == '6') b.need(at + 1 + size.width * size.height * bytesPerValue * 3);
  return size;
}

/// "Pf" or "PF", width, height and scale in text, one blank behind each, then floats. OpenCV reads two blanks
/// as a number 0, and leaves a file in the temporary folder where a side is not positive.
Size inspectPfm(const Bytes& b) {
  std::uint64_t at = 3;
  const auto word = [&] { return b.takeUntil(" \t\r\n", at); };
  const auto side = [&] {
    const auto digits = word();
    if (digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string_view::npos)
      throw Damaged();
    return static_cast<std::uint64_t>(toNumber(digits).value_or(0));
  };
  Size size{"PFM", side(), 0};
  size.height = side();
  if (!toNumber(word())) throw Damaged();  // the scale
  if (size.width * size.height <= maxPixels)
    b.need(at + size.width * size.height * (b.data[1] == 'F' ? 12 : 4));
  return size;
}

/// The data window among the header's attributes: name\0 type\0 size value.
Size inspectExr(const Bytes& b) {
  const std::string_view zero("\0", 1);
  Size size{"OpenEXR", 0, 0};
  for (std::uint64_t at = 8;;) {
    const auto name = b.takeUntil(zero, at);
    if (name.empty()) return size;
    b.takeUntil(zero, at);
    const auto length = b.little(at, 4);
    at += 4;
    if (name == "dataWindow") {
      const auto width = b.littleSigned32(at + 8) - b.littleSigned32(at) + 1;
      const auto height = b.littleSigned32(at + 12) - b.littleSigned32(at + 4) + 1;
      if (width <= 0 || height <= 0 || size.width > 0) throw Damaged();  // OpenEXR takes the last of several
      size = {"OpenEXR", static_cast<std::uint64_t>(width), static_cast<std::uint64_t>(height)};
    }
    at += length;
    b.need(at);
  }
}

/// The line "-Y height +X width" behind an empty line.
Size inspectRadiance(const Bytes& b) {
  const auto blank = b.data.find("\n\n");
  if (blank == std::string_view::npos) throw CutOff();
  const auto end = b.data.find('\n', blank + 2);
  if (end == std::string_view::npos) throw CutOff();
  const auto words = wordsOf(b.data.substr(blank + 2, end - blank - 2));
  const auto height = words.size() == 4 ? toNumber(words[1]) : std::nullopt;
  const auto width = words.size() == 4 ? toNumber(words[3]) : std::nullopt;
  if (!height || !width || !(*height >= 1 && *height < 1e9) || !(*width >= 1 && *width < 1e9))
    throw Damaged();
  return {"Radiance", static_cast<std::uint64_t>(*width), static_cast<std::uint64_t>(*height)};
}

using Inspect = Size (*)(const Bytes&);

/// Accepts what OpenCV recognizes, by the same bytes: what its decoders of images refuse it gives to those of
/// medical images and of maps (GDCM, GDAL), which may end the program.
Inspect findFormat(const Bytes& b) {
  using namespace std::string_view_literals;
  if (b.startsWith("\xFF\xD8\xFF")) return inspectJpeg;
  if (b.startsWith("\x89PNG\r\n\x1A\n")) return inspectPng;
  if (b.startsWith("BM")) return inspectBmp;
  if (b.startsWith("II*\0"sv) || b.startsWith("MM\0*"sv) || b.startsWith("II+\0"sv) ||
      b.startsWith("MM\0+"sv))
    return inspectTiff;
  if (b.startsWith("RIFF") && "WEBP"sv.starts_with(b.data.substr(std::min<std::size_t>(b.data.size(), 8), 4)))
    return inspectWebp;  // also one that is cut off before its size
  if (b.startsWith("\x76\x2F\x31\x01")) return inspectExr;
  if (b.startsWith("#?RADIANCE") || b.startsWith("#?RGBE")) return inspectRadiance;
  if (b.data.size() > 2 && b.data[0] == 'P' && b.data[1] >= '1' && b.data[1] <= '6' &&
      "\n\r\t "sv.find(b.data[2]) != std::string_view::npos)
    return inspectPnm;
  if (b.startsWith("Pf\n") || b.startsWith("PF\n")) return inspectPfm;
  return nullptr;
}

}  // namespace

ImageHeader inspectImage(std::string_view bytes, const std::string& file) {
  if (bytes.empty()) fail(ErrorCode::truncatedFile, "{}: empty file; copy it again", file);
  const Bytes b{bytes};
  const Inspect inspect = findFormat(b);
  if (inspect == nullptr)
    fail(ErrorCode::unsupportedFile,
         "{}: not an image (JPEG, PNG, BMP, TIFF, WebP, PGM, PPM); remove or convert it", file);
  try {
    ImageHeader header = inspect(b);
    if (header.width == 0 || header.height == 0) throw Damaged();
    if (header.width > maxPixels || header.height > maxPixels || header.width * header.height > maxPixels)
      fail(ErrorCode::tooLarge, "{}: {} × {} pixels; at most {} are read; reduce its size", file,
           header.width, header.height, maxPixels);
    return header;
  } catch (const CutOff&) {
    fail(ErrorCode::truncatedFile, "{}: truncated image; copy it again", file);
  } catch (const Damaged&) {
    fail(ErrorCode::malformedFile, "{}: damaged image header; copy it again", file);
  }
}

}  // namespace estancia::io

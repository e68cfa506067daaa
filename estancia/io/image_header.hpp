// Image header: format and size of an image file, checked before a decoder allocates memory.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace estancia::io {

struct ImageHeader {
  std::string format;  ///< "JPEG", "PNG", "BMP", "TIFF", "WebP", "PNM", "PFM", "OpenEXR", "Radiance"
  std::uint64_t width = 0, height = 0;

  bool isRadiance() const { return format == "OpenEXR" || format == "Radiance"; }
};

/// Recognizes the format by content, never by name, and reads the declared size. Throws Error, naming `file`,
/// when the bytes are no image, declare no pixels or more than 2^26 (67 million), or end before the image
/// does: decoders fill the rest of a truncated JPEG or TIFF with gray and say nothing. Damage inside complete
/// data is left to the decoders (PNG has checksums, JPEG has none).
ImageHeader inspectImage(std::string_view bytes, const std::string& file);

}  // namespace estancia::io

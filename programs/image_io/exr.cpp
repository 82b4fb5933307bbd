// SPDX-License-Identifier: Apache-2.0
#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStdIO.h>

#include <array>
#include <fstream>
#include <stdexcept>

#include "image_io/formats.hpp"

namespace manylight::image_io::detail {

namespace {

constexpr std::size_t k_pixel_bytes = sizeof(Rgb<float>);
static_assert(k_pixel_bytes == 3 * sizeof(float), "rows of pixels are handed to OpenEXR as floats");

/// The channels that hold red, green and blue: R G B, or Y three times.
std::array<std::string, 3> colour_channels(const std::filesystem::path& path, const Imf::ChannelList& channels) {
  if (channels.findChannel("R") && channels.findChannel("G") && channels.findChannel("B")) return {"R", "G", "B"};
  if (channels.findChannel("Y")) return {"Y", "Y", "Y"};
  std::string found;
  for (auto it = channels.begin(); it != channels.end(); ++it)
    found += std::string(found.empty() ? "" : ", ") + it.name();
  throw ImageFileError(path, "channels are " + found + "; supported are R, G, B or Y");
}

void refuse_subsampling(const std::filesystem::path& path, const Imf::Channel& channel) {
  if (channel.xSampling != 1 || channel.ySampling != 1)
    throw ImageFileError(path, "subsampled channels are not supported");
}

/// Where OpenEXR stores one channel so that the corner of the data window becomes pixel (0, 0).
Imf::Slice slice_of(Image<float>& image, int channel, const Imath::Box2i& window) {
  char* first = reinterpret_cast<char*>(image.pixels.data()) + static_cast<std::size_t>(channel) * sizeof(float);
  return Imf::Slice::Make(Imf::FLOAT, first, window, k_pixel_bytes, k_pixel_bytes * image.width);
}

Image<float> read(const std::filesystem::path& path) {
  Imf::InputFile file(path.c_str());
  const Imath::Box2i window = file.header().dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  check_size(path, width, height);
  const Imf::ChannelList& channels = file.header().channels();
  const std::array<std::string, 3> names = colour_channels(path, channels);
  refuse_subsampling(path, *channels.findChannel(names[0].c_str()));
  Image<float> image(static_cast<std::size_t>(width), static_cast<std::size_t>(height));
  const bool is_grey = names[0] == names[1];
  Imf::FrameBuffer buffer;
  for (int c = 0; c < (is_grey ? 1 : 3); ++c) {
    buffer.insert(names[static_cast<std::size_t>(c)].c_str(), slice_of(image, c, window));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  if (is_grey) {
    for (Rgb<float>& pixel : image.pixels) pixel = Rgb<float>(pixel.x);
  }
  return image;
}

}  // namespace

Image<float> read_exr(const std::filesystem::path& path) {
  try {
    return read(path);
  } catch (const ImageFileError&) {
    throw;
  } catch (const std::exception& error) {  // OpenEXR's own messages name the file, often over several lines
    const std::string text = error.what();
    throw ImageFileError(path, "not a readable EXR image: " + text.substr(0, text.find('\n')));
  }
}

void write_exr(const std::filesystem::path& path, const Image<float>& image) {
  try {
    const int width = static_cast<int>(image.width);
    const int height = static_cast<int>(image.height);
    Imf::Header header(width, height, 1.0F, Imath::V2f(0.0F), 1.0F, Imf::INCREASING_Y, Imf::ZIP_COMPRESSION);
    Imf::FrameBuffer buffer;
    const std::array<const char*, 3> names{"R", "G", "B"};
    for (std::size_t c = 0; c < 3; ++c) {
      header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
      // OpenEXR reads through the same non-const slices that it writes to.
      buffer.insert(names[c], slice_of(const_cast<Image<float>&>(image), static_cast<int>(c), header.dataWindow()));
    }
    // Through memory: OpenEXR's own file stream ends without an error when the disk is full.
    Imf::StdOSStream bytes;
    {
      Imf::OutputFile file(bytes, header);
      file.setFrameBuffer(buffer);
      file.writePixels(height);
    }
    std::ofstream out(path, std::ios::binary);
    out << bytes.str();
    out.close();
    if (!out) throw std::runtime_error("no space left, or the folder is not writable");
  } catch (const std::exception& error) {
    const std::string text = error.what();
    throw ImageFileError(path, "cannot be written: " + text.substr(0, text.find('\n')));
  }
}

}  // namespace manylight::image_io::detail

#include "engine/scene/gltf_file.h"

#include "base/input_error.h"
#include "base/one_line.h"
#include "base/wanted.h"

// tinygltf is compiled here rather than taken from libtinygltf.so: Debian's libdraco.so exports
// another version of the same functions, and the order of a program's libraries would decide which
// of the two it gets. Images are decoded elsewhere.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <new>
#include <string>

namespace springdrive::scene::gltf {

namespace {

/// tinygltf's image callback: decoding waits until an image proves to be needed. The bytes of an
/// image in a buffer view must not be touched here, since tinygltf has not checked its bounds.
bool keep_encoded(tinygltf::Image *image, int /*index*/, std::string * /*error*/,
                  std::string * /*warning*/, int /*width*/, int /*height*/,
                  const unsigned char *bytes, int size, void * /*user*/) {
    image->as_is = true;
    if (image->bufferView < 0 && size > 0) {
        image->image.assign(bytes, bytes + size);
    }
    return true;
}

/// tinygltf also looks for a file's companions in the current folder; only those beside it are
/// read.
bool is_companion(const std::string &path, void *folder) {
    return path.starts_with(*static_cast<const std::string *>(folder)) &&
           std::filesystem::is_regular_file(path);
}

bool read_companion(Bytes *bytes, std::string *error, const std::string &path, void * /*folder*/) {
    try {
        *bytes = read_bytes(path);
        return true;
    } catch (const InputError &problem) {
        *error += problem.what();
        return false;
    }
}

} // namespace

tinygltf::Model parse(std::span<const unsigned char> bytes, bool is_binary,
                      const std::filesystem::path &folder) {
    std::string base = folder.string();
    tinygltf::TinyGLTF reader;
    reader.SetStoreOriginalJSONForExtrasAndExtensions(true); // for gltf_nodes.cpp
    reader.SetImageLoader(&keep_encoded, nullptr);
    reader.SetFsCallbacks(
        {&is_companion, &tinygltf::ExpandFilePath, &read_companion, nullptr, &base});
    tinygltf::Model model;
    std::string error;
    std::string warning; // about images only, which are found empty where they are needed
    const auto size = static_cast<unsigned int>(bytes.size());
    bool done = false;
    try {
        if (is_binary) {
            done = reader.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(), size, base);
        } else {
            const auto *const text = reinterpret_cast<const char *>(bytes.data());
            done = reader.LoadASCIIFromString(&model, &error, &warning, text, size, base);
        }
    } catch (const NotWanted &) {
        throw;
    } catch (const std::bad_alloc &) {
        throw; // not an error in the file's grammar
    } catch (const std::exception &problem) {
        error += problem.what();
    }
    if (!done || !error.empty()) {
        throw InputError("is no valid glTF: " + one_line(error));
    }
    return model;
}

} // namespace springdrive::scene::gltf

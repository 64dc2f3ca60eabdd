#include "engine/scene/gltf_file.h"

#include "base/input_error.h"
#include "base/text.h"

// tinygltf is compiled here rather than taken from libtinygltf.so: Debian's libdraco.so exports
// another version of the same functions, and the order of a program's libraries would decide which
// of the two it gets. Images are read and decoded elsewhere.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <new>
#include <string>

namespace springdrive::scene::gltf {

tinygltf::Model parse(const std::string &text) {
    tinygltf::TinyGLTF reader;
    reader.SetStoreOriginalJSONForExtrasAndExtensions(true); // for gltf_nodes.cpp
    reader.SetFsCallbacks({});
    tinygltf::Model model;
    std::string error;
    std::string warning; // on images only
    bool done = false;
    try {
        done = reader.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                          static_cast<unsigned int>(text.size()), "");
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

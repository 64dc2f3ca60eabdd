#include "engine/scene/gltf_meshopt.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/one_line.h"
#include "engine/scene/gltf_accessor.h"

#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include <span>
#include <string>

namespace springdrive::scene::gltf {

namespace {

constexpr std::size_t kMaxDecoded_bytes = 2'000'000'000; // over all views, as for one file

/// What the extension says about a buffer view.
struct CompressedView {
    std::size_t count = 0;
    std::size_t stride_bytes = 0;
    std::string mode;
    std::string filter;
    std::span<const unsigned char> bytes;

    [[nodiscard]] std::size_t decoded_bytes() const { return count * stride_bytes; }
};

std::size_t read_whole(const tinygltf::Value &extension, const char *key, const std::string &place,
                       bool is_required) {
    const tinygltf::Value &value = extension.Get(key);
    if (!is_required && value.Type() == tinygltf::NULL_TYPE) {
        return 0;
    }
    if (!value.IsInt() || value.GetNumberAsInt() < 0) {
        throw InputError(place + ": its " + key + " must be a whole number from 0");
    }
    return static_cast<std::size_t>(value.GetNumberAsInt());
}

std::string read_text(const tinygltf::Value &extension, const char *key,
                      const std::string &otherwise) {
    const tinygltf::Value &value = extension.Get(key);
    return value.IsString() ? value.Get<std::string>() : otherwise;
}

/// Whether elements of `stride_bytes` can be in that mode, and pass that filter.
bool is_possible(const CompressedView &view) {
    const std::size_t stride = view.stride_bytes;
    if (view.mode == "TRIANGLES" || view.mode == "INDICES") {
        return (stride == 2 || stride == 4) && view.filter == "NONE" &&
               (view.mode == "INDICES" || view.count % 3 == 0);
    }
    return view.mode == "ATTRIBUTES" && stride > 0 && stride <= 256 && stride % 4 == 0 &&
           (view.filter == "NONE" || view.filter == "EXPONENTIAL" ||
            (view.filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) ||
            (view.filter == "QUATERNION" && stride == 8));
}

CompressedView read_view(const tinygltf::Model &model, const tinygltf::Value &extension,
                         const std::string &place) {
    CompressedView view;
    view.count = read_whole(extension, "count", place, true);
    view.stride_bytes = read_whole(extension, "byteStride", place, true);
    view.mode = read_text(extension, "mode", "");
    view.filter = read_text(extension, "filter", "NONE");
    if (!is_possible(view)) {
        throw InputError(place + ": mode " + in_quotes(view.mode) + " with filter " +
                         in_quotes(view.filter) + " does not exist for " +
                         std::to_string(view.count) + " elements of " +
                         std::to_string(view.stride_bytes) + " bytes");
    }
    if (view.count > kMaxVertices) {
        throw InputError(place + ": holds " + std::to_string(view.count) + " elements; at most " +
                         std::to_string(kMaxVertices) + " are allowed");
    }
    const std::size_t buffer = read_whole(extension, "buffer", place, true);
    view.bytes = bytes_within(model, static_cast<int>(buffer),
                              read_whole(extension, "byteOffset", place, false),
                              read_whole(extension, "byteLength", place, true), place);
    return view;
}

std::vector<unsigned char> decoded(const CompressedView &view, const std::string &place) {
    std::vector<unsigned char> bytes(view.decoded_bytes());
    const std::span<const unsigned char> from = view.bytes;
    int error = 0;
    if (view.mode == "ATTRIBUTES") {
        error = meshopt_decodeVertexBuffer(bytes.data(), view.count, view.stride_bytes, from.data(),
                                           from.size());
    } else if (view.mode == "TRIANGLES") {
        error = meshopt_decodeIndexBuffer(bytes.data(), view.count, view.stride_bytes, from.data(),
                                          from.size());
    } else {
        error = meshopt_decodeIndexSequence(bytes.data(), view.count, view.stride_bytes,
                                            from.data(), from.size());
    }
    if (error != 0) {
        throw InputError(place + ": its compressed data are damaged; export it again");
    }
    if (view.filter == "OCTAHEDRAL") {
        meshopt_decodeFilterOct(bytes.data(), view.count, view.stride_bytes);
    } else if (view.filter == "QUATERNION") {
        meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride_bytes);
    } else if (view.filter == "EXPONENTIAL") {
        meshopt_decodeFilterExp(bytes.data(), view.count, view.stride_bytes);
    }
    return bytes;
}

} // namespace

void decode_meshopt_views(tinygltf::Model &model) {
    std::size_t total_bytes = 0;
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
        tinygltf::BufferView &target = model.bufferViews[i];
        const auto extension = target.extensions.find(kMeshoptExtension);
        if (extension == target.extensions.end()) {
            continue;
        }
        stop_if_given_up();
        const std::string place = "buffer view " + std::to_string(i) + ": " + kMeshoptExtension;
        const CompressedView view = read_view(model, extension->second, place);
        total_bytes += view.decoded_bytes();
        if (total_bytes > kMaxDecoded_bytes) {
            throw InputError(place +
                             ": with it, the decoded data take more than 2 GB; simplify it");
        }
        tinygltf::Buffer buffer;
        buffer.data = decoded(view, place);
        target.buffer = static_cast<int>(model.buffers.size());
        target.byteOffset = 0;
        target.byteLength = buffer.data.size();
        model.buffers.push_back(std::move(buffer));
    }
}

} // namespace springdrive::scene::gltf

#include "engine/scene/gltf_accessor.h"

#include "base/cancellation.h"
#include "base/input_error.h"
#include "base/text.h"

#include <draco/compression/decode.h>
#include <meshoptimizer.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>
#include <limits>

namespace springdrive::scene::gltf {

namespace {

std::string name_of(int accessor) { return "accessor " + std::to_string(accessor); }

const tinygltf::Accessor &find_accessor(const tinygltf::Model &model, int index) {
    return checked(model.accessors, index, "accessor");
}

std::size_t component_size(int component_type, const std::string &place) {
    switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        throw InputError(place + ": component type " + std::to_string(component_type) +
                         " is not one of glTF's");
    }
}

template <typename Component> Component load(const unsigned char *bytes) {
    Component value{};
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

template <typename Integer> double to_number(const unsigned char *bytes, bool normalised) {
    const double value = load<Integer>(bytes);
    return normalised ? std::max(value / std::numeric_limits<Integer>::max(), -1.0) : value;
}

double load_number(const unsigned char *bytes, int component_type, bool normalised) {
    switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return to_number<std::int8_t>(bytes, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return to_number<std::uint8_t>(bytes, normalised);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return to_number<std::int16_t>(bytes, normalised);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return to_number<std::uint16_t>(bytes, normalised);
    default:
        return static_cast<double>(load<float>(bytes));
    }
}

std::uint32_t load_index(const unsigned char *bytes, int component_type) {
    switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return load<std::uint8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return load<std::uint16_t>(bytes);
    default:
        return load<std::uint32_t>(bytes);
    }
}

bool is_index_type(int component_type) {
    return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

/// A run of equally spaced elements that all lie within their buffer view.
struct Elements {
    const unsigned char *first = nullptr;
    std::size_t stride = 0;

    [[nodiscard]] const unsigned char *operator[](std::size_t i) const {
        return first + i * stride;
    }
};

Elements find_elements(const tinygltf::Model &model, int view, std::size_t offset,
                       std::size_t count, std::size_t element_size, const std::string &place) {
    const std::span<const unsigned char> bytes = view_bytes(model, view);
    const std::size_t declared = model.bufferViews[static_cast<std::size_t>(view)].byteStride;
    const std::size_t stride = declared == 0 ? element_size : declared;
    if (stride < element_size) {
        throw InputError(place + ": its elements take " + std::to_string(element_size) +
                         " bytes, but stand " + std::to_string(stride) + " apart");
    }
    const bool fits =
        count == 0 || (offset <= bytes.size() && element_size <= bytes.size() - offset &&
                       count - 1 <= (bytes.size() - offset - element_size) / stride);
    if (!fits) {
        throw InputError(place + ": its " + std::to_string(count) +
                         " elements reach beyond buffer view " + std::to_string(view) + " of " +
                         std::to_string(bytes.size()) + " bytes");
    }
    return {count == 0 ? bytes.data() : bytes.data() + offset, stride};
}

void check_count(const tinygltf::Accessor &accessor, const std::string &place) {
    if (accessor.count > kMaxVertices) {
        throw InputError(place + ": holds " + std::to_string(accessor.count) +
                         " elements; at most " + std::to_string(kMaxVertices) + " are allowed");
    }
}

/// Calls `replace(index, bytes)` for each element that a sparse accessor overrides.
/// @param elements  how many of the accessor's are read
template <typename Replace>
void for_each_sparse(const tinygltf::Model &model, const tinygltf::Accessor &accessor,
                     std::size_t elements, std::size_t element_size, const std::string &place,
                     Replace &&replace) {
    if (!accessor.sparse.isSparse) {
        return;
    }
    const auto &sparse = accessor.sparse;
    if (sparse.count < 0 || static_cast<std::size_t>(sparse.count) > elements ||
        sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 ||
        !is_index_type(sparse.indices.componentType)) {
        throw InputError(place + ": its sparse part has an impossible count, offset or type");
    }
    const auto count = static_cast<std::size_t>(sparse.count);
    const Elements indices = find_elements(
        model, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
        count, component_size(sparse.indices.componentType, place), place);
    const Elements values = find_elements(model, sparse.values.bufferView,
                                          static_cast<std::size_t>(sparse.values.byteOffset), count,
                                          element_size, place);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t index = load_index(indices[i], sparse.indices.componentType);
        if (index >= elements) {
            throw InputError(place + ": sparse index " + std::to_string(index) + " is beyond its " +
                             std::to_string(elements) + " elements");
        }
        replace(index, values[i]);
    }
}

/// The first `count` elements of an accessor, of `width` numbers each.
std::vector<double> read_numbers(const tinygltf::Model &model, int index, std::size_t width,
                                 std::size_t count, bool normalised) {
    const tinygltf::Accessor &accessor = find_accessor(model, index);
    const std::string place = name_of(index);
    const int type = accessor.componentType;
    const std::size_t size = component_size(type, place);
    const bool has_view = accessor.bufferView >= 0; // without one all but sparse values are zero
    Elements elements;
    if (has_view) {
        elements = find_elements(model, accessor.bufferView, accessor.byteOffset, count,
                                 width * size, place);
    }
    std::vector<double> numbers(count * width);
    const auto load_element = [&](std::size_t i, const unsigned char *bytes) {
        for (std::size_t c = 0; c < width; ++c) {
            numbers[i * width + c] = load_number(bytes + c * size, type, normalised);
        }
    };
    for (std::size_t i = 0; has_view && i < count; ++i) {
        stop_if_given_up(i);
        load_element(i, elements[i]);
    }
    for_each_sparse(model, accessor, count, width * size, place, load_element);
    return numbers;
}

/// The largest integer of a type, by which a normalised value is divided; 1 for floats.
double full_scale(draco::DataType type) {
    switch (type) {
    case draco::DT_INT8:
        return 127.0;
    case draco::DT_UINT8:
        return 255.0;
    case draco::DT_INT16:
        return 32767.0;
    case draco::DT_UINT16:
        return 65535.0;
    default:
        return 1.0;
    }
}

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

/// Whether it needs a later version of the library.
bool is_of_later_version(const CompressedView &view) {
    constexpr unsigned char kFirstAttributes = 0xa0; // the version is in the lower four bits
    return view.filter == "COLOR" ||
           (view.mode == "ATTRIBUTES" && !view.bytes.empty() &&
            (view.bytes[0] & 0xf0U) == kFirstAttributes && view.bytes[0] != kFirstAttributes);
}

CompressedView read_view(const tinygltf::Model &model, const tinygltf::Value &extension,
                         const std::string &place) {
    CompressedView view;
    view.count = read_whole(extension, "count", place, true);
    view.stride_bytes = read_whole(extension, "byteStride", place, true);
    view.mode = read_text(extension, "mode", "");
    view.filter = read_text(extension, "filter", "NONE");
    if (!is_possible(view) && !(view.filter == "COLOR" && view.mode == "ATTRIBUTES")) {
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

std::span<const unsigned char> view_bytes(const tinygltf::Model &model, int view) {
    const std::string place = "buffer view " + std::to_string(view);
    const tinygltf::BufferView &description = checked(model.bufferViews, view, "buffer view");
    return bytes_within(model, description.buffer, description.byteOffset, description.byteLength,
                        place);
}

std::span<const unsigned char> bytes_within(const tinygltf::Model &model, int buffer,
                                            std::size_t offset, std::size_t length,
                                            const std::string &place) {
    if (buffer < 0 || static_cast<std::size_t>(buffer) >= model.buffers.size()) {
        throw InputError(place + ": buffer " + std::to_string(buffer) + " is not in the file");
    }
    const std::span<const unsigned char> bytes(
        model.buffers[static_cast<std::size_t>(buffer)].data);
    if (bytes.empty() && length > 0) {
        throw InputError(place + ": buffer " + std::to_string(buffer) +
                         " has no uri, so the file does not say where its bytes are");
    }
    if (offset > bytes.size() || length > bytes.size() - offset) {
        throw InputError(place + ": " + std::to_string(length) + " bytes from " +
                         std::to_string(offset) + " reach beyond buffer " + std::to_string(buffer) +
                         " of " + std::to_string(bytes.size()) + " bytes");
    }
    return bytes.subspan(offset, length);
}

Attribute read_attribute(const tinygltf::Model &model, int index, Scaling scaling) {
    const tinygltf::Accessor &accessor = find_accessor(model, index);
    check_count(accessor, name_of(index));
    if (accessor.type < TINYGLTF_TYPE_VEC2 || accessor.type > TINYGLTF_TYPE_VEC4 ||
        accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) {
        throw InputError(name_of(index) + ": a vertex attribute is a vector of floats or of 8- or "
                                          "16-bit integers");
    }
    const auto width = static_cast<std::size_t>(accessor.type); // TINYGLTF_TYPE_VECn is n
    return {accessor.type, read_numbers(model, index, width, accessor.count,
                                        accessor.normalized || scaling == Scaling::unit_range)};
}

std::vector<double> read_matrices(const tinygltf::Model &model, int index, std::size_t count) {
    const tinygltf::Accessor &accessor = find_accessor(model, index);
    if (accessor.type != TINYGLTF_TYPE_MAT4 ||
        accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT || accessor.count < count) {
        throw InputError(name_of(index) + ": it takes " + std::to_string(count) +
                         " matrices of 4 by 4 floats");
    }
    return read_numbers(model, index, 16, count, false);
}

void check_shape(const Attribute &attribute, const std::string &name, int minimum, int maximum,
                 std::size_t count) {
    if (attribute.empty()) {
        return;
    }
    if (attribute.components < minimum || attribute.components > maximum) {
        throw InputError(name + " has " + std::to_string(attribute.components) +
                         " numbers a vertex; it takes " + std::to_string(maximum));
    }
    if (attribute.count() != count) {
        throw InputError(name + " has " + std::to_string(attribute.count()) + " entries for " +
                         std::to_string(count) + " vertices");
    }
}

void check_finite(const Attribute &attribute, const std::string &name) {
    const auto bad = std::ranges::find_if_not(attribute.values,
                                              [](double number) { return std::isfinite(number); });
    if (bad != attribute.values.end()) {
        const auto index = static_cast<std::size_t>(bad - attribute.values.begin());
        throw InputError(name + " of vertex " +
                         std::to_string(index / static_cast<std::size_t>(attribute.components)) +
                         " is not finite");
    }
}

std::vector<std::uint32_t> read_indices(const tinygltf::Model &model, int index) {
    const tinygltf::Accessor &accessor = find_accessor(model, index);
    const std::string place = name_of(index);
    check_count(accessor, place);
    const int type = accessor.componentType;
    if (accessor.type != TINYGLTF_TYPE_SCALAR || !is_index_type(type)) {
        throw InputError(place + ": indices are scalars of 8, 16 or 32 bits, unsigned");
    }
    const std::size_t size = component_size(type, place);
    std::vector<std::uint32_t> indices(accessor.count);
    const bool has_view = accessor.bufferView >= 0; // without one all but sparse values are zero
    Elements elements;
    if (has_view) {
        elements = find_elements(model, accessor.bufferView, accessor.byteOffset, accessor.count,
                                 size, place);
    }
    for (std::size_t i = 0; has_view && i < accessor.count; ++i) {
        stop_if_given_up(i);
        indices[i] = load_index(elements[i], type);
    }
    for_each_sparse(
        model, accessor, accessor.count, size, place,
        [&](std::size_t i, const unsigned char *bytes) { indices[i] = load_index(bytes, type); });
    return indices;
}

std::size_t accessor_count(const tinygltf::Model &model, int accessor) {
    return find_accessor(model, accessor).count;
}

bool is_normalised(const tinygltf::Model &model, int accessor) {
    return find_accessor(model, accessor).normalized;
}

DracoMesh::DracoMesh(std::span<const unsigned char> bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    const auto type = draco::Decoder::GetEncodedGeometryType(&buffer);
    if (!type.ok() || type.value() != draco::TRIANGULAR_MESH) {
        throw InputError("its Draco data hold no triangle mesh");
    }
    draco::Decoder decoder;
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) {
        throw InputError("its Draco data are damaged: " +
                         one_line(mesh.status().error_msg_string()));
    }
    mesh_ = std::move(mesh).value();
}

DracoMesh::~DracoMesh() = default;

std::vector<Triangle> DracoMesh::triangles() const {
    std::vector<Triangle> triangles;
    triangles.reserve(mesh_->num_faces());
    for (std::uint32_t i = 0; i < mesh_->num_faces(); ++i) {
        const draco::Mesh::Face &face = mesh_->face(draco::FaceIndex(i));
        triangles.push_back({face[0].value(), face[1].value(), face[2].value()});
    }
    return triangles;
}

Attribute DracoMesh::attribute(std::uint32_t id, bool normalised) const {
    const draco::PointAttribute *const source = mesh_->GetAttributeByUniqueId(id);
    if (source == nullptr || source->num_components() < 2 || source->num_components() > 4) {
        throw InputError("its Draco data hold no vectors with the id " + std::to_string(id));
    }
    // Draco has divided already where its data say that the integers are normalised.
    const bool divide = normalised && !source->normalized();
    const double scale = divide ? full_scale(source->data_type()) : 1.0;
    const auto width = static_cast<std::size_t>(source->num_components());
    Attribute attribute{static_cast<int>(width),
                        std::vector<double>(std::size_t{mesh_->num_points()} * width)};
    for (std::uint32_t point = 0; point < mesh_->num_points(); ++point) {
        const draco::AttributeValueIndex value = source->mapped_index(draco::PointIndex(point));
        double *const target = &attribute.values[point * width];
        if (value.value() >= source->size() || !source->ConvertValue<double>(value, target)) {
            throw InputError("its Draco data cannot be read as numbers");
        }
        if (divide) {
            std::transform(target, target + width, target,
                           [&](double number) { return std::max(number / scale, -1.0); });
        }
    }
    return attribute;
}

void decode_meshopt_views(tinygltf::Model &model) {
    std::size_t total_bytes = 0;
    for (std::size_t i = 0; i < model.bufferViews.size(); ++i) {
        tinygltf::BufferView &target = model.bufferViews[i];
        const auto name = std::ranges::find_if(kMeshoptExtensions, [&](const char *extension) {
            return target.extensions.contains(extension);
        });
        if (name == kMeshoptExtensions.end()) {
            continue;
        }
        stop_if_given_up();
        const std::string place = "buffer view " + std::to_string(i) + ": " + *name;
        const CompressedView view = read_view(model, target.extensions.at(*name), place);
        if (is_of_later_version(view)) {
            if (target.buffer >= 0 &&
                static_cast<std::size_t>(target.buffer) < model.buffers.size() &&
                !model.buffers[static_cast<std::size_t>(target.buffer)].data.empty()) {
                continue; // the same, uncompressed
            }
            throw InputError(place +
                             ": is compressed in a way that is not supported; export it "
                             "with " +
                             kMeshoptExtensions[0]);
        }
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

/* The one door to Draco, and the only C++ of the project.
 *
 * Draco allocates what the bytes tell it to: files of 43 bytes make it ask for gigabytes. A point
 * count cannot bound that, so this file replaces the global operator new. Without a meter it is
 * malloc and costs one thread-local load; while a call of this file is on the stack, every
 * allocation of its thread is booked on the meter, and past the meter's answer "no" it throws
 * std::bad_alloc, which each function here turns into VOR_DRACO_NO_MEMORY. The executable's
 * operator new wins over libstdc++'s for the shared libdraco too. Draco has no over-aligned new. */
#include "proto/draco/draco_shim.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <malloc.h>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace
{

/* What a meter has been charged through this file and not been given back. */
struct Account {
    vor_draco_meter meter;
    size_t booked;
};

thread_local Account *current = nullptr;

/* Books a thread's allocations on an account for as long as it lives; NULL books nothing. */
class Scope
{
  public:
    explicit Scope(Account *account) : before_(current)
    {
        current = account;
    }
    ~Scope()
    {
        current = before_;
    }
    Scope(const Scope &) = delete;
    Scope &operator=(const Scope &) = delete;

  private:
    Account *before_;
};

void settle(Account *account)
{
    account->meter.release(account->meter.ctx, account->booked);
    account->booked = 0;
}

bool charge(size_t bytes)
{
    if (!current->meter.charge(current->meter.ctx, bytes))
        return false;
    current->booked += bytes;
    return true;
}

void discharge(size_t bytes)
{
    /* A block from before the scope was never booked. */
    if (bytes > current->booked)
        bytes = current->booked;
    current->meter.release(current->meter.ctx, bytes);
    current->booked -= bytes;
}

/* Books before it allocates, and then corrects the bill to what malloc really set aside, which is
 * what the block gives back when it is freed. */
void *metered(size_t bytes)
{
    void *p;
    size_t actual;

    if (!charge(bytes))
        return nullptr;
    p = std::malloc(bytes);
    if (p == nullptr) {
        discharge(bytes);
        return nullptr;
    }
    actual = malloc_usable_size(p);
    if (actual > bytes && !charge(actual - bytes)) {
        std::free(p);
        discharge(bytes);
        return nullptr;
    }
    return p;
}

void *allocate(size_t bytes)
{
    if (bytes == 0)
        bytes = 1;
    if (current != nullptr)
        return metered(bytes);
    for (;;) {
        void *p = std::malloc(bytes);
        std::new_handler handler = std::get_new_handler();

        if (p != nullptr || handler == nullptr)
            return p;
        handler();
    }
}

void *allocate_or_throw(size_t bytes)
{
    void *p = allocate(bytes);

    if (p == nullptr)
        throw std::bad_alloc();
    return p;
}

void release(void *p) noexcept
{
    if (p != nullptr && current != nullptr)
        discharge(malloc_usable_size(p));
    std::free(p);
}

} /* namespace */

void *operator new(size_t bytes)
{
    return allocate_or_throw(bytes);
}

void *operator new[](size_t bytes)
{
    return allocate_or_throw(bytes);
}

void *operator new(size_t bytes, const std::nothrow_t &) noexcept
{
    return allocate(bytes);
}

void *operator new[](size_t bytes, const std::nothrow_t &) noexcept
{
    return allocate(bytes);
}

void operator delete(void *p) noexcept
{
    release(p);
}

void operator delete[](void *p) noexcept
{
    release(p);
}

void operator delete(void *p, size_t) noexcept
{
    release(p);
}

void operator delete[](void *p, size_t) noexcept
{
    release(p);
}

void operator delete(void *p, const std::nothrow_t &) noexcept
{
    release(p);
}

void operator delete[](void *p, const std::nothrow_t &) noexcept
{
    release(p);
}

struct vor_draco_decoded {
    Account account;
    std::unique_ptr<draco::PointCloud> cloud;
    bool mesh;
};

namespace
{

const draco::DataType data_types[VOR_DRACO_SCALAR_COUNT] = {
    draco::DT_INT8,   draco::DT_UINT8,   draco::DT_INT16,   draco::DT_UINT16, draco::DT_INT32,
    draco::DT_UINT32, draco::DT_FLOAT32, draco::DT_FLOAT64, draco::DT_INT64,  draco::DT_UINT64};

vor_draco_result refuse(char message[96], const char *text)
{
    (void)std::snprintf(message, 96, "%s", text);
    return VOR_DRACO_REFUSED;
}

/* Runs body with the account's meter on; every exception ends here. */
template <typename Body>
vor_draco_result guarded(Account *account, char *message, Body body) noexcept
{
    char unused[96];

    if (message == nullptr)
        message = unused;
    message[0] = '\0';
    try {
        Scope scope(account);

        return body(message);
    } catch (const std::bad_alloc &) {
        return VOR_DRACO_NO_MEMORY;
    } catch (const std::exception &e) {
        return refuse(message, e.what());
    } catch (...) {
    }
    return VOR_DRACO_REFUSED;
}

bool text_entry(const draco::Metadata *metadata, const char *key, char *out, size_t size)
{
    std::string value;

    out[0] = '\0';
    if (metadata == nullptr || !metadata->GetEntryString(key, &value))
        return false;
    (void)std::snprintf(out, size, "%s", value.c_str());
    return true;
}

/* The address of a point's value, or NULL when the file promised more than it holds. */
class Values
{
  public:
    Values(const draco::PointCloud &cloud, const draco::PointAttribute &attribute)
        : attribute_(attribute), identity_(attribute.is_mapping_identity())
    {
        const draco::DataBuffer *buffer = attribute.buffer();

        width_ = size_t(attribute.num_components()) *
                 size_t(draco::DataTypeLength(attribute.data_type()));
        points_ = identity_ ? cloud.num_points() : attribute.indices_map_size();
        count_ = attribute.size();
        if (buffer == nullptr || attribute.byte_offset() != 0 ||
            attribute.byte_stride() != int64_t(width_) || width_ == 0)
            count_ = 0;
        else if (count_ > buffer->data_size() / width_)
            count_ = buffer->data_size() / width_;
        data_ = count_ > 0 ? buffer->data() : nullptr;
    }

    bool index(size_t point, uint32_t *out) const
    {
        if (point >= points_)
            return false;
        *out = identity_ ? uint32_t(point)
                         : attribute_.mapped_index(draco::PointIndex(uint32_t(point))).value();
        return *out < count_;
    }

    const uint8_t *at(uint32_t index) const
    {
        return data_ + width_ * index;
    }

    size_t width() const
    {
        return width_;
    }

  private:
    const draco::PointAttribute &attribute_;
    bool identity_;
    size_t points_, count_, width_;
    const uint8_t *data_;
};

vor_draco_result decode(vor_draco_decoded *decoded, const uint8_t *bytes, size_t *size,
                        char *message)
{
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;

    buffer.Init(reinterpret_cast<const char *>(bytes), *size);
    auto type = draco::Decoder::GetEncodedGeometryType(&buffer);
    if (!type.ok())
        return refuse(message, type.status().error_msg());
    decoded->mesh = type.value() == draco::TRIANGULAR_MESH;
    auto cloud = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!cloud.ok())
        return refuse(message, cloud.status().error_msg());
    decoded->cloud = std::move(cloud).value();
    *size -= size_t(buffer.remaining_size());
    return decoded->cloud ? VOR_DRACO_DONE : VOR_DRACO_REFUSED;
}

int add_column(draco::PointCloud *cloud, const vor_draco_column &column, size_t n)
{
    const draco::DataType type = data_types[column.scalar];
    const int64_t stride = int64_t(column.components) * draco::DataTypeLength(type);
    const auto kind = static_cast<draco::GeometryAttribute::Type>(column.kind);
    const bool normalized = column.kind == VOR_DRACO_COLOR && column.scalar != VOR_DRACO_FLOAT32 &&
                            column.scalar != VOR_DRACO_FLOAT64;
    draco::GeometryAttribute shape;
    int id;

    shape.Init(kind, nullptr, uint8_t(column.components), type, normalized, stride, 0);
    id = cloud->AddAttribute(shape, true, uint32_t(n));
    if (id < 0)
        return id;
    cloud->attribute(id)->buffer()->Write(0, column.data, size_t(stride) * n);
    if (column.name != nullptr || column.type != nullptr) {
        std::unique_ptr<draco::AttributeMetadata> metadata(new draco::AttributeMetadata());

        if (column.name != nullptr)
            metadata->AddEntryString("name", column.name);
        if (column.type != nullptr)
            metadata->AddEntryString("voronoid.type", column.type);
        cloud->AddAttributeMetadata(id, std::move(metadata));
    }
    return id;
}

const char *const origin_keys[3] = {"voronoid.origin.x", "voronoid.origin.y", "voronoid.origin.z"};

/* Single doubles, because draco3d (npm) has no getter for an array of them. */
void add_origin(draco::PointCloud *cloud, const vor_draco_source &source)
{
    if (cloud->metadata() == nullptr)
        cloud->AddMetadata(std::unique_ptr<draco::GeometryMetadata>(new draco::GeometryMetadata()));
    for (int c = 0; c < 3; c++)
        cloud->metadata()->AddEntryDouble(origin_keys[c], source.origin[c]);
    cloud->metadata()->AddEntryString("voronoid.position_type", source.position_type);
}

bool origin_entries(const draco::Metadata *metadata, double origin[3])
{
    int found = 0;

    while (found < 3 && metadata->GetEntryDouble(origin_keys[found], &origin[found]))
        found++;
    return found == 3;
}

/* The nesting is bounded (draco_precheck.h). */
size_t foreign_entries(const draco::Metadata &metadata, bool is_attribute)
{
    size_t count = 0;

    for (const auto &entry : metadata.entries())
        count +=
            entry.first.compare(0, 9, "voronoid.") != 0 && !(is_attribute && entry.first == "name");
    for (const auto &inner : metadata.sub_metadatas())
        count += foreign_entries(*inner.second, false);
    return count;
}

bool fill(draco::Mesh *mesh, const vor_draco_source &source)
{
    mesh->set_num_points(uint32_t(source.n));
    for (unsigned i = 0; i < source.count; i++)
        if (add_column(mesh, source.columns[i], source.n) != int(i))
            return false;
    if (source.origin != nullptr)
        add_origin(mesh, source);
    mesh->SetNumFaces(source.triangle_count);
    for (size_t i = 0; i < source.triangle_count; i++) {
        const uint32_t *corner = source.triangles + 3 * i;

        mesh->SetFace(draco::FaceIndex(uint32_t(i)),
                      {draco::PointIndex(corner[0]), draco::PointIndex(corner[1]),
                       draco::PointIndex(corner[2])});
    }
    return true;
}

std::string exact(float value)
{
    char text[32];

    (void)std::snprintf(text, sizeof text, "%.9g", double(value));
    return text;
}

/* What SetAttributeExplicitQuantization sets, but that writes floats with six decimals. */
draco::Options quantization(const vor_draco_column &column)
{
    draco::Options options;
    std::string low;

    for (unsigned c = 0; c < column.components; c++)
        low += exact(column.low[c]) + " ";
    options.SetInt("quantization_bits", column.bits);
    options.SetString("quantization_origin", low);
    options.SetString("quantization_range", exact(column.range));
    return options;
}

vor_draco_result encode(const vor_draco_source &source, draco::EncoderBuffer *out, char *message)
{
    draco::Mesh mesh; /* without triangles it is the point cloud that it is made of */

    if (!fill(&mesh, source))
        return refuse(message, "an attribute cannot be added");
    draco::ExpertEncoder encoder =
        source.triangles != nullptr
            ? draco::ExpertEncoder(mesh)
            : draco::ExpertEncoder(static_cast<const draco::PointCloud &>(mesh));
    encoder.SetTrackEncodedProperties(true);
    encoder.SetSpeedOptions(source.speed, source.speed);
    encoder.SetEncodingMethod(source.reorders ? draco::POINT_CLOUD_KD_TREE_ENCODING
                                              : draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
    encoder.options().SetGlobalBool("compress_connectivity", source.n <= size_t(1) << 20);
    for (unsigned i = 0; i < source.count; i++)
        if (source.columns[i].bits > 0)
            encoder.options().SetAttributeOptions(int(i), quantization(source.columns[i]));
    const draco::Status status = encoder.EncodeToBuffer(out);
    if (!status.ok())
        return refuse(message, status.error_msg());
    if (encoder.num_encoded_points() != source.n ||
        encoder.num_encoded_faces() != source.triangle_count || out->size() == 0)
        return refuse(message, "points or faces are missing");
    return VOR_DRACO_DONE;
}

static_assert(int(draco::MESH_EDGEBREAKER_ENCODING) == int(draco::POINT_CLOUD_KD_TREE_ENCODING),
              "one number is the method of both geometries; sequential is 0");

} /* namespace */

vor_draco_result vor_draco_decode(vor_draco_decoded **out, const vor_draco_meter *meter,
                                  const uint8_t *bytes, size_t *size, char message[96]) noexcept
{
    vor_draco_decoded *decoded = new (std::nothrow) vor_draco_decoded();
    vor_draco_result result;

    *out = nullptr;
    message[0] = '\0';
    if (decoded == nullptr)
        return VOR_DRACO_NO_MEMORY;
    decoded->account.meter = *meter;
    result = guarded(&decoded->account, message,
                     [&](char *text) { return decode(decoded, bytes, size, text); });
    if (result != VOR_DRACO_DONE) {
        vor_draco_free(decoded);
        return result;
    }
    *out = decoded;
    return VOR_DRACO_DONE;
}

void vor_draco_free(vor_draco_decoded *decoded) noexcept
{
    if (decoded == nullptr)
        return;
    {
        Scope scope(&decoded->account);

        decoded->cloud.reset();
    }
    settle(&decoded->account);
    delete decoded;
}

size_t vor_draco_points(const vor_draco_decoded *decoded) noexcept
{
    return decoded->cloud->num_points();
}

size_t vor_draco_faces(const vor_draco_decoded *decoded) noexcept
{
    return decoded->mesh ? static_cast<const draco::Mesh *>(decoded->cloud.get())->num_faces() : 0;
}

vor_draco_result vor_draco_corners(const vor_draco_decoded *decoded, uint32_t *out) noexcept
{
    const size_t points = decoded->cloud->num_points(), faces = vor_draco_faces(decoded);
    const draco::Mesh *mesh;

    if (faces == 0)
        return VOR_DRACO_DONE; /* nor need it be a mesh */
    mesh = static_cast<const draco::Mesh *>(decoded->cloud.get());
    for (size_t i = 0; i < faces; i++)
        for (int k = 0; k < 3; k++) {
            out[3 * i + size_t(k)] = mesh->face(draco::FaceIndex(uint32_t(i)))[size_t(k)].value();
            if (out[3 * i + size_t(k)] >= points)
                return VOR_DRACO_REFUSED;
        }
    return VOR_DRACO_DONE;
}

unsigned vor_draco_attributes(const vor_draco_decoded *decoded) noexcept
{
    return unsigned(decoded->cloud->num_attributes());
}

vor_draco_result vor_draco_describe(const vor_draco_decoded *decoded, unsigned index,
                                    vor_draco_info *out) noexcept
{
    Account account = {decoded->account.meter, 0};
    vor_draco_result result = guarded(&account, nullptr, [&](char *) {
        const draco::PointAttribute *attribute = decoded->cloud->attribute(int(index));
        const draco::DataType type =
            attribute->data_type() == draco::DT_BOOL ? draco::DT_UINT8 : attribute->data_type();
        const draco::Metadata *metadata =
            decoded->cloud->GetAttributeMetadataByAttributeId(int(index));
        const int kind = attribute->attribute_type();
        int scalar = 0;

        while (scalar < VOR_DRACO_SCALAR_COUNT && data_types[scalar] != type)
            scalar++;
        if (scalar == VOR_DRACO_SCALAR_COUNT)
            return VOR_DRACO_REFUSED;
        out->kind = kind >= VOR_DRACO_POSITION && kind <= VOR_DRACO_GENERIC
                        ? static_cast<vor_draco_kind>(kind)
                        : VOR_DRACO_GENERIC;
        out->scalar = static_cast<vor_draco_scalar>(scalar);
        out->components = attribute->num_components();
        text_entry(metadata, "name", out->name, sizeof out->name);
        text_entry(metadata, "voronoid.type", out->type, sizeof out->type);
        return VOR_DRACO_DONE;
    });

    settle(&account);
    return result;
}

vor_draco_result vor_draco_values(const vor_draco_decoded *decoded, unsigned index,
                                  void *out) noexcept
{
    const Values source(*decoded->cloud, *decoded->cloud->attribute(int(index)));
    const size_t n = decoded->cloud->num_points();
    uint8_t *to = static_cast<uint8_t *>(out);
    uint32_t value;

    for (size_t i = 0; i < n; i++, to += source.width()) {
        if (!source.index(i, &value))
            return VOR_DRACO_REFUSED;
        std::memcpy(to, source.at(value), source.width());
    }
    return VOR_DRACO_DONE;
}

size_t vor_draco_metadata(const vor_draco_decoded *decoded) noexcept
{
    const draco::GeometryMetadata *metadata = decoded->cloud->GetMetadata();
    size_t count = metadata != nullptr ? foreign_entries(*metadata, false) : 0;

    for (size_t i = 0; metadata != nullptr && i < metadata->attribute_metadatas().size(); i++)
        count += foreign_entries(*metadata->attribute_metadatas()[i], true);
    return count;
}

int vor_draco_origin(const vor_draco_decoded *decoded, double origin[3], char type[16]) noexcept
{
    Account account = {decoded->account.meter, 0};
    vor_draco_result result = guarded(&account, nullptr, [&](char *) {
        const draco::Metadata *metadata = decoded->cloud->GetMetadata();

        type[0] = '\0';
        if (metadata == nullptr || !origin_entries(metadata, origin))
            return VOR_DRACO_REFUSED;
        text_entry(metadata, "voronoid.position_type", type, 16);
        return VOR_DRACO_DONE;
    });

    settle(&account);
    return result == VOR_DRACO_DONE;
}

vor_draco_result vor_draco_encode(const vor_draco_source *source, const vor_draco_meter *meter,
                                  void *ctx,
                                  int (*write)(void *ctx, const void *bytes, size_t size),
                                  char message[96]) noexcept
{
    Account account = {*meter, 0};
    vor_draco_result result = guarded(&account, message, [&](char *text) {
        draco::EncoderBuffer out;
        vor_draco_result encoded = encode(*source, &out, text);

        if (encoded != VOR_DRACO_DONE)
            return encoded;
        Scope off(nullptr);
        return write(ctx, out.data(), out.size()) == 0 ? VOR_DRACO_DONE : VOR_DRACO_NOT_TAKEN;
    });

    settle(&account);
    return result;
}

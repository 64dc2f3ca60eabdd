// OpenGL objects that are deleted with their owner. Shaders are compiled here, and OpenGL errors
// are converted to exceptions. Everything here needs a current GL context.
#pragma once

#include <epoxy/gl.h>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace springdrive::app {

/// @throw std::runtime_error with `where` and the error's name if OpenGL has one pending.
void check_gl(std::string_view where);

/// Owns one OpenGL name; `Kind` creates and destroys it.
template <typename Kind> class GlName {
public:
    GlName() : name_(Kind::create()) {}
    GlName(GlName &&other) noexcept : name_(std::exchange(other.name_, 0)) {}
    GlName &operator=(GlName &&other) noexcept {
        std::swap(name_, other.name_);
        return *this;
    }
    GlName(const GlName &) = delete;
    GlName &operator=(const GlName &) = delete;
    ~GlName() {
        if (name_ != 0) {
            Kind::destroy(name_);
        }
    }

    [[nodiscard]] GLuint name() const { return name_; }

private:
    GLuint name_;
};

struct BufferKind {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct VertexArrayKind {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct TextureKind {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct FramebufferKind {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct RenderbufferKind {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct QueryKind {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};
struct ProgramKind {
    static GLuint create();
    static void destroy(GLuint name) noexcept;
};

using Buffer = GlName<BufferKind>;
using VertexArray = GlName<VertexArrayKind>;
using Framebuffer = GlName<FramebufferKind>;
using Renderbuffer = GlName<RenderbufferKind>;
using Query = GlName<QueryKind>;

// As OpenGL's own, and counted.
void draw_arrays(GLenum mode, GLsizei count);
void draw_elements(GLenum mode, GLsizei count); ///< of the bound indices, all from the first
[[nodiscard]] int draw_calls();                 ///< of this thread so far

/// A vertex and a fragment shader, linked.
class Program {
public:
    /// Sources must not contain #version, which is prepended: GLSL 3.30 core.
    /// @param defines  macros to define in both shaders
    /// @throw std::runtime_error with `name` and OpenGL's log if they do not compile or link.
    Program(std::string name, std::string_view vertex, std::string_view fragment,
            std::span<const std::string_view> defines = {});

    void use() const { glUseProgram(program_.name()); }

    // Uniforms of the program in use. An unknown name throws std::logic_error.
    void set(std::string_view uniform, int value) const;
    void set(std::string_view uniform, float value) const;
    void set(std::string_view uniform, const glm::vec2 &value) const;
    void set(std::string_view uniform, const glm::vec3 &value) const;
    void set(std::string_view uniform, const glm::vec4 &value) const;
    void set(std::string_view uniform, const glm::mat3 &value) const;
    void set(std::string_view uniform, const glm::mat4 &value) const;

private:
    [[nodiscard]] GLint location(std::string_view uniform) const;

    std::string name_;
    GlName<ProgramKind> program_;
    std::map<std::string, GLint, std::less<>> locations_;
};

/// A two-dimensional texture, filtered linearly.
class Texture2D {
public:
    struct Format {
        GLint internal = GL_RGBA8;
        GLenum pixels = GL_RGBA; ///< of the uploaded data, one byte per channel
        GLint wrap_s = GL_CLAMP_TO_EDGE;
        GLint wrap_t = GL_CLAMP_TO_EDGE;
        bool mipmaps = false;
    };

    /// @param pixels first row at t = 0, without padding; empty leaves the content undefined
    Texture2D(int width, int height, const Format &format, std::span<const std::uint8_t> pixels);

    void bind(int unit) const;
    [[nodiscard]] GLuint name() const { return texture_.name(); }

private:
    GlName<TextureKind> texture_;
};

/// A square texture of depths. Reading compares with a depth: 1 where that is not behind, filtered
/// linearly; and 1 beyond its edges.
class DepthTexture {
public:
    explicit DepthTexture(int size);

    void bind(int unit) const;
    [[nodiscard]] GLuint name() const { return texture_.name(); }

private:
    GlName<TextureKind> texture_;
};

} // namespace springdrive::app

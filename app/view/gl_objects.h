// OpenGL objects that are deleted with their owner, a framebuffer with several samples per pixel,
// and what a frame takes. Shaders are compiled here, and OpenGL errors are converted to exceptions.
// Everything here needs a current GL context.
#pragma once

#include <epoxy/gl.h>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <map>
#include <memory>
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

/// By two functions of OpenGL that make and delete any number of names.
template <auto &generate, auto &remove> struct GlKind {
    static GLuint create() {
        GLuint name = 0;
        generate(1, &name);
        return name;
    }
    static void destroy(GLuint name) noexcept { remove(1, &name); }
};
struct ProgramKind {
    static GLuint create() { return glCreateProgram(); }
    static void destroy(GLuint name) noexcept { glDeleteProgram(name); }
};

using Buffer = GlName<GlKind<glGenBuffers, glDeleteBuffers>>;
using VertexArray = GlName<GlKind<glGenVertexArrays, glDeleteVertexArrays>>;
using Framebuffer = GlName<GlKind<glGenFramebuffers, glDeleteFramebuffers>>;
using Renderbuffer = GlName<GlKind<glGenRenderbuffers, glDeleteRenderbuffers>>;
using Query = GlName<GlKind<glGenQueries, glDeleteQueries>>;
using Texture = GlName<GlKind<glGenTextures, glDeleteTextures>>;

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
    Texture texture_;
};

/// A square texture of depths. Reading compares with a depth: 1 where that is not behind, filtered
/// linearly; and 1 beyond its edges.
class DepthTexture {
public:
    explicit DepthTexture(int size);

    void bind(int unit) const;
    [[nodiscard]] GLuint name() const { return texture_.name(); }

private:
    Texture texture_;
};

class MultisampledTarget {
public:
    /// @param samples  per pixel, as far as OpenGL has them; 0 for a plain framebuffer
    explicit MultisampledTarget(int samples) : samples_(samples) {}

    /// Binds it to be drawn into, with this size. Its contents are undefined.
    /// @throw std::runtime_error if OpenGL cannot draw into it
    void begin(int width, int height);

    /// Copies it, each pixel the mean of its samples, into the framebuffer `to`, which is bound
    /// afterwards. @param x, y  lower left corner there
    void end(GLuint to, int x, int y) const;

private:
    struct Buffers {
        Buffers(int samples, int width, int height);

        Framebuffer framebuffer;
        Renderbuffer colour;
        Renderbuffer depth;
        int width;
        int height;
    };

    int samples_;
    std::unique_ptr<Buffers> buffers_; ///< of the size that was used last
};

/// Of one frame, with the passes for its shadows.
struct FrameLoad {
    int draw_calls = 0;
    std::uint64_t primitives = 0; ///< triangles and lines that were sent
    std::uint64_t samples = 0;    ///< that passed the depth test, of all passes
};

/// Measures one frame after the other. The card answers later: a frame is left out while the one
/// before is not answered, so that measuring never waits.
class FrameLoadMeter {
public:
    void begin();
    void end();

    [[nodiscard]] const FrameLoad &latest() const { return latest_; }

private:
    void take_answer();

    Query primitives_;
    Query samples_;
    bool is_asked_ = false;  ///< and not answered
    bool is_within_ = false; ///< a frame that is measured
    int calls_before_ = 0;
    int calls_ = 0; ///< of the frame that is asked for
    FrameLoad latest_;
};

} // namespace springdrive::app

#include "app/view/gl_objects.h"

#include <glm/gtc/type_ptr.hpp>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

namespace springdrive::app {

namespace {

std::string_view error_name(GLenum error) {
    switch (error) {
    case GL_INVALID_ENUM:
        return "invalid enum";
    case GL_INVALID_VALUE:
        return "invalid value";
    case GL_INVALID_OPERATION:
        return "invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
        return "invalid framebuffer operation";
    case GL_OUT_OF_MEMORY:
        return "out of memory";
    default:
        return "unknown error";
    }
}

/// One shader of a program, needed until the program is linked.
class Shader {
public:
    Shader(GLenum stage, const std::string &program, std::span<const std::string_view> defines,
           std::string_view source)
        : name_(glCreateShader(stage)) {
        std::string head = "#version 330 core\n";
        for (const std::string_view define : defines) {
            head.append("#define ").append(define).append("\n");
        }
        head.append("#line 1\n"); // line numbers in the log then match the file
        const std::array<const char *, 2> texts{head.data(), source.data()};
        const std::array<GLint, 2> lengths{static_cast<GLint>(head.size()),
                                           static_cast<GLint>(source.size())};
        glShaderSource(name_, 2, texts.data(), lengths.data());
        glCompileShader(name_);
        GLint compiled = GL_FALSE;
        glGetShaderiv(name_, GL_COMPILE_STATUS, &compiled);
        if (compiled == GL_FALSE) {
            const std::string message =
                (stage == GL_VERTEX_SHADER ? "vertex shader of '" : "fragment shader of '") +
                program + "' does not compile: " + log();
            glDeleteShader(name_);
            throw std::runtime_error(message);
        }
    }
    Shader(const Shader &) = delete;
    Shader &operator=(const Shader &) = delete;
    ~Shader() { glDeleteShader(name_); }

    [[nodiscard]] GLuint name() const { return name_; }

private:
    [[nodiscard]] std::string log() const {
        GLint length = 0;
        glGetShaderiv(name_, GL_INFO_LOG_LENGTH, &length);
        std::string text(static_cast<std::size_t>(length), '\0');
        glGetShaderInfoLog(name_, length, &length, text.data());
        text.resize(static_cast<std::size_t>(length));
        return text;
    }

    GLuint name_;
};

std::string link_log(GLuint program) {
    GLint length = 0;
    glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
    std::string text(static_cast<std::size_t>(length), '\0');
    glGetProgramInfoLog(program, length, &length, text.data());
    text.resize(static_cast<std::size_t>(length));
    return text;
}

std::map<std::string, GLint, std::less<>> uniform_locations(GLuint program) {
    GLint count = 0;
    GLint longest = 0;
    glGetProgramiv(program, GL_ACTIVE_UNIFORMS, &count);
    glGetProgramiv(program, GL_ACTIVE_UNIFORM_MAX_LENGTH, &longest);
    std::vector<GLchar> name(static_cast<std::size_t>(longest) + 1);
    std::map<std::string, GLint, std::less<>> locations;
    for (GLint i = 0; i < count; ++i) {
        GLint size = 0;
        GLenum type = 0;
        glGetActiveUniform(program, static_cast<GLuint>(i), static_cast<GLsizei>(name.size()),
                           nullptr, &size, &type, name.data());
        locations.emplace(name.data(), glGetUniformLocation(program, name.data()));
    }
    return locations;
}

thread_local int calls_of_thread = 0;

} // namespace

void check_gl(std::string_view where) {
    if (const GLenum error = glGetError(); error != GL_NO_ERROR) {
        throw std::runtime_error("OpenGL reports '" + std::string(error_name(error)) + "' in " +
                                 std::string(where));
    }
}

void draw_arrays(GLenum mode, GLsizei count) {
    ++calls_of_thread;
    glDrawArrays(mode, 0, count);
}

void draw_elements(GLenum mode, GLsizei count) {
    ++calls_of_thread;
    glDrawElements(mode, count, GL_UNSIGNED_INT, nullptr);
}

int draw_calls() { return calls_of_thread; }

Program::Program(std::string name, std::string_view vertex, std::string_view fragment,
                 std::span<const std::string_view> defines)
    : name_(std::move(name)) {
    const Shader vertex_shader(GL_VERTEX_SHADER, name_, defines, vertex);
    const Shader fragment_shader(GL_FRAGMENT_SHADER, name_, defines, fragment);
    glAttachShader(program_.name(), vertex_shader.name());
    glAttachShader(program_.name(), fragment_shader.name());
    glLinkProgram(program_.name());
    GLint linked = GL_FALSE;
    glGetProgramiv(program_.name(), GL_LINK_STATUS, &linked);
    if (linked == GL_FALSE) {
        throw std::runtime_error("shaders of '" + name_ +
                                 "' do not link: " + link_log(program_.name()));
    }
    glDetachShader(program_.name(), vertex_shader.name());
    glDetachShader(program_.name(), fragment_shader.name());
    locations_ = uniform_locations(program_.name());
}

GLint Program::location(std::string_view uniform) const {
    const auto found = locations_.find(uniform);
    if (found == locations_.end()) {
        throw std::logic_error("shaders of '" + name_ + "' have no uniform '" +
                               std::string(uniform) + "'");
    }
    return found->second;
}

void Program::set(std::string_view uniform, int value) const {
    glUniform1i(location(uniform), value);
}
void Program::set(std::string_view uniform, float value) const {
    glUniform1f(location(uniform), value);
}
void Program::set(std::string_view uniform, const glm::vec2 &value) const {
    glUniform2fv(location(uniform), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform, const glm::vec3 &value) const {
    glUniform3fv(location(uniform), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform, const glm::vec4 &value) const {
    glUniform4fv(location(uniform), 1, glm::value_ptr(value));
}
void Program::set(std::string_view uniform, const glm::mat3 &value) const {
    glUniformMatrix3fv(location(uniform), 1, GL_FALSE, glm::value_ptr(value));
}
void Program::set(std::string_view uniform, const glm::mat4 &value) const {
    glUniformMatrix4fv(location(uniform), 1, GL_FALSE, glm::value_ptr(value));
}

Texture2D::Texture2D(int width, int height, const Format &format,
                     std::span<const std::uint8_t> pixels) {
    glBindTexture(GL_TEXTURE_2D, texture_.name());
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexImage2D(GL_TEXTURE_2D, 0, format.internal, width, height, 0, format.pixels,
                 GL_UNSIGNED_BYTE, pixels.empty() ? nullptr : pixels.data());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, format.wrap_s);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, format.wrap_t);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER,
                    format.mipmaps ? GL_LINEAR_MIPMAP_LINEAR : GL_LINEAR);
    if (format.mipmaps) {
        glGenerateMipmap(GL_TEXTURE_2D);
    }
}

void Texture2D::bind(int unit) const {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D, texture_.name());
}

DepthTexture::DepthTexture(int size) {
    glBindTexture(GL_TEXTURE_2D, texture_.name());
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT,
                 GL_UNSIGNED_INT, nullptr);
    constexpr std::array<GLfloat, 4> kFarthest{1.0F, 1.0F, 1.0F, 1.0F};
    glTexParameterfv(GL_TEXTURE_2D, GL_TEXTURE_BORDER_COLOR, kFarthest.data());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_BORDER);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
}

void DepthTexture::bind(int unit) const {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D, texture_.name());
}

MultisampledTarget::Buffers::Buffers(int requested, int wide, int high)
    : width(wide), height(high) {
    GLint most = 0;
    glGetIntegerv(GL_MAX_SAMPLES, &most);
    const GLint samples = std::min(requested, most);
    glBindRenderbuffer(GL_RENDERBUFFER, colour.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, width, height);
    glBindRenderbuffer(GL_RENDERBUFFER, depth.name());
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
    glBindRenderbuffer(GL_RENDERBUFFER, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth.name());
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
        throw std::runtime_error("OpenGL cannot draw into a framebuffer with several samples");
    }
}

void MultisampledTarget::begin(int width, int height) {
    if (buffers_ == nullptr || buffers_->width != width || buffers_->height != height) {
        buffers_.reset(); // first, so that both are never held
        buffers_ = std::make_unique<Buffers>(samples_, width, height);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, buffers_->framebuffer.name());
    glViewport(0, 0, width, height);
}

void MultisampledTarget::end(GLuint to, int x, int y) const {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, buffers_->framebuffer.name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
    glBlitFramebuffer(0, 0, buffers_->width, buffers_->height, x, y, x + buffers_->width,
                      y + buffers_->height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, to);
}

void FrameLoadMeter::begin() {
    take_answer();
    is_within_ = !is_asked_;
    if (is_within_) {
        calls_before_ = draw_calls();
        glBeginQuery(GL_PRIMITIVES_GENERATED, primitives_.name());
        glBeginQuery(GL_SAMPLES_PASSED, samples_.name());
    }
}

void FrameLoadMeter::end() {
    if (is_within_) {
        glEndQuery(GL_SAMPLES_PASSED);
        glEndQuery(GL_PRIMITIVES_GENERATED);
        calls_ = draw_calls() - calls_before_;
        is_asked_ = true;
        is_within_ = false;
    }
}

void FrameLoadMeter::take_answer() {
    if (!is_asked_) {
        return;
    }
    GLuint is_there = GL_FALSE; // of the samples, which are known last
    glGetQueryObjectuiv(samples_.name(), GL_QUERY_RESULT_AVAILABLE, &is_there);
    if (is_there == GL_FALSE) {
        return;
    }
    GLuint primitives = 0;
    GLuint samples = 0;
    glGetQueryObjectuiv(primitives_.name(), GL_QUERY_RESULT, &primitives);
    glGetQueryObjectuiv(samples_.name(), GL_QUERY_RESULT, &samples);
    latest_ = {calls_, primitives, samples};
    is_asked_ = false;
}

} // namespace springdrive::app

// Draws a picture of half floats by WebGL2. What is shown is decided in the shader: exposure and tone
// curve, the overlay of a matte, the new colour in it. The values stay as they are.

const VERTEX = `#version 300 es
uniform vec4 place; // x y width height of the picture in the canvas, pixels from the top left
uniform vec2 canvas;
out vec2 at;
void main() {
    at = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec2 p = (place.xy + at * place.zw) / canvas * 2.0 - 1.0;
    gl_Position = vec4(p.x, -p.y, 0, 1);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D picture, mask;
uniform float gain;
uniform int tone, show; // show: 0 picture, 1 overlay, 2 isolate, 3 matte
uniform bool change; // recolour what the matte covers, by own and lead of recolour.js
uniform vec3 own, lead;
uniform int leading;
in vec2 at;
out vec4 screen;

vec3 encode(vec3 v) {
    return mix(12.92 * v, 1.055 * pow(max(v, vec3(1e-9)), vec3(1.0 / 2.4)) - 0.055,
               vec3(greaterThan(v, vec3(0.0031308))));
}

vec3 shown(vec3 v) {
    v *= gain;
    v = vec3(v.x > 0.0 ? v.x : 0.0, v.y > 0.0 ? v.y : 0.0, v.z > 0.0 ? v.z : 0.0);
    return encode(tone == 1 ? 1.0 - 1.0 / (1.0 + v) : min(v, vec3(1)));
}

// What the surface shows in a pixel that other things share; as in recolour.js.
vec3 at_edge(ivec2 p, vec3 light, float alpha) {
    ivec2 last = textureSize(picture, 0) - 1;
    vec4 sum = vec4(0);
    for (int dy = -2; dy <= 2; dy++)
        for (int dx = -2; dx <= 2; dx++) {
            ivec2 q = p + ivec2(dx, dy);
            if (clamp(q, ivec2(0), last) != q) continue;
            float w = pow(texelFetch(mask, q, 0).r, 8.0) / float(1 + dx * dx + dy * dy);
            if (w > 0.0) sum += w * vec4(texelFetch(picture, q, 0).rgb, 1);
        }
    return min(sum.a > 0.0 ? sum.rgb / sum.a : vec3(0), light / alpha);
}

vec3 recoloured(vec3 light, float alpha) {
    if (alpha == 0.0) return light;
    ivec2 p = ivec2(at * vec2(textureSize(picture, 0)));
    vec3 f = alpha == 1.0 ? light : at_edge(p, light, alpha);
    return light + alpha * (own * f + lead * f[leading] - f);
}

void main() {
    vec3 light = texture(picture, at).rgb;
    float m = show > 0 || change ? texture(mask, at).r : 0.0;
    vec3 c = shown(change ? recoloured(light, m) : light);
    if (show == 1) c = mix(c, vec3(1.0, 0.42, 0.25), 0.55 * m);
    if (show == 2) c = mix(0.35 * vec3(dot(c, vec3(0.3, 0.6, 0.1))), c, m);
    if (show == 3) c = vec3(m);
    screen = vec4(c, 1);
}`;

const UNIFORMS = ["picture", "mask", "place", "canvas", "gain", "tone", "show", "change", "own", "lead", "leading"];

function compile(gl, type, source) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    return shader;
}

function link(gl) {
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl, gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, compile(gl, gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
}

function texture(gl, unit) {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
        gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
        gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
}

export class GlDisplay {
    constructor(canvas, lost) {
        const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false });
        if (!gl) throw new Error("no WebGL2");
        this.canvas = canvas;
        this.gl = gl;
        const program = link(gl);
        gl.useProgram(program);
        this.at = Object.fromEntries(UNIFORMS.map((name) => [name, gl.getUniformLocation(program, name)]));
        gl.uniform1i(this.at.picture, 0);
        gl.uniform1i(this.at.mask, 1);
        for (const unit of [0, 1]) texture(gl, unit);
        gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
        canvas.addEventListener("webglcontextlost", (event) => {
            event.preventDefault();
            lost();
        }, { once: true });
    }

    // An Error where the driver takes no picture of that size.
    setSize(width, height) {
        const { gl } = this;
        if (Math.max(width, height) > gl.getParameter(gl.MAX_TEXTURE_SIZE)) throw new Error("too large for WebGL2");
        gl.activeTexture(gl.TEXTURE0);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, width, height, 0, gl.RGBA, gl.HALF_FLOAT,
            new Uint16Array(4 * width * height));
    }

    // pixels: halves, four for each pixel of the rectangle.
    update(x, y, width, height, pixels) {
        const { gl } = this;
        gl.activeTexture(gl.TEXTURE0);
        gl.texSubImage2D(gl.TEXTURE_2D, 0, x, y, width, height, gl.RGBA, gl.HALF_FLOAT, pixels);
    }

    setMask(width, height, coverage) {
        const { gl } = this;
        gl.activeTexture(gl.TEXTURE1);
        gl.texImage2D(gl.TEXTURE_2D, 0, gl.R8, width, height, 0, gl.RED, gl.UNSIGNED_BYTE, coverage);
    }

    draw({ place, exposure, tone, show, change, backdrop }) {
        const { gl, canvas } = this;
        gl.viewport(0, 0, canvas.width, canvas.height);
        gl.clearColor(backdrop, backdrop, backdrop, 1);
        gl.clear(gl.COLOR_BUFFER_BIT);
        if (!place) return;
        gl.activeTexture(gl.TEXTURE0);
        gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, place.smooth ? gl.LINEAR : gl.NEAREST);
        gl.uniform4f(this.at.place, place.x, place.y, place.width, place.height);
        gl.uniform2f(this.at.canvas, canvas.width, canvas.height);
        gl.uniform1f(this.at.gain, 2 ** exposure);
        gl.uniform1i(this.at.tone, tone === "reinhard" ? 1 : 0);
        gl.uniform1i(this.at.show, show);
        gl.uniform1i(this.at.change, change ? 1 : 0);
        if (change) {
            gl.uniform3f(this.at.own, ...change.own);
            gl.uniform3f(this.at.lead, ...change.lead);
            gl.uniform1i(this.at.leading, change.j);
        }
        gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    }
}

// Shaders: pads coloured by value, transparent object.
const VERTEX = `#version 300 es
in vec3 position, normal;
in float value;
uniform mat4 model, camera;
uniform float lift;
out vec3 world, bent;
out float amount;
void main() {
  vec4 at = model * vec4(position, 1.0);
  world = at.xyz;
  bent = mat3(model) * normal;
  amount = value;
  gl_Position = camera * at;
  gl_Position.z -= lift * gl_Position.w;
}`;

// Half-Lambert shading: gradual, without black regions. Faces without vertex normals are shaded flat.
const SURFACE = `#version 300 es
precision highp float;
in vec3 world, bent;
in float amount;
uniform sampler2D colors;
uniform vec3 light, towards;
uniform vec4 ink;
out vec4 color;
void main() {
  vec3 n = dot(bent, bent) > 0.25 ? normalize(bent) : normalize(cross(dFdx(world), dFdy(world)));
  n *= sign(dot(n, towards)) + step(abs(dot(n, towards)), 0.0);
  float shade = 0.64 + 0.40 * pow(0.5 + 0.5 * dot(n, light), 2.0);
  vec4 lit = vec4(min(texture(colors, vec2(amount, 0.5)).rgb * shade, 1.0), 1.0);
  color = ink.a > 0.0 ? vec4(ink.rgb * ink.a, ink.a) : lit;
}`;

const GLASS = `#version 300 es
precision highp float;
in vec3 world, bent;
in float amount;
uniform vec3 light, towards;
uniform vec4 ink;
out vec4 color;
void main() {
  vec3 n = normalize(bent);
  float face = abs(dot(n, towards));
  float alpha = ink.a * mix(0.7, 0.09, smoothstep(0.0, 0.9, face));
  float shade = 0.7 + 0.4 * pow(0.5 + 0.5 * dot(n, light), 2.0);
  color = vec4(min(ink.rgb * shade, 1.0) * alpha, alpha);
}`;

function program(gl, fragment) {
  const out = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(out, shader);
  }
  ["position", "normal", "value"].forEach((name, place) => gl.bindAttribLocation(out, place, name));
  gl.linkProgram(out);
  if (!gl.getProgramParameter(out, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(out));
  const places = {};
  for (let i = 0; i < gl.getProgramParameter(out, gl.ACTIVE_UNIFORMS); i++) {
    const { name } = gl.getActiveUniform(out, i);
    places[name] = gl.getUniformLocation(out, name);
  }
  return { out, places };
}

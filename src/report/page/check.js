// Self-test of the viewer for addresses that end in `#check`; the result is stored on the body as JSON.
function check() {
  const { viewer } = controls;
  const { gl, canvas } = viewer;
  // Fingerprint of a picture: number of non-empty pixels and a checksum.
  const look = () => {
    controls.draw();
    const pixels = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let [full, sum] = [0, 0];
    for (let i = 0; i < pixels.length; i += 4) {
      full += pixels[i + 3] > 0;
      sum = (Math.imul(sum, 31) + pixels[i] + 256 * pixels[i + 1] + 65536 * pixels[i + 2]) | 0;
    }
    return { full: full / (pixels.length / 4), sum };
  };
  const pick = (name, value) => {
    const input = document.querySelector(`input[name="${name}"][value="${value}"]`);
    if (!input.disabled) input.checked = true;
    return !input.disabled;
  };
  const found = { drawn: look().full, changes: {}, glError: 0, grasps: data.grasps.length };
  const changes = (name, act) => {
    const before = look();
    if (act() === false) return;
    const after = look();
    found.changes[name] = after.sum !== before.sum && after.full > 0.01;
  };
  changes("frame", () => { byId("frame").value = 0; });
  byId("frame").value = byId("frame").max;
  changes("turn", () => { viewer.turn(0.4, 0.2); });
  changes("zoom", () => { viewer.zoom(1.3); });
  changes("stress", () => pick("quantity", "stress"));
  changes("contact_force", () => pick("quantity", "contact_force"));
  pick("quantity", "displacement");
  changes("prediction", () => pick("show", "prediction"));
  changes("difference", () => pick("show", "difference"));
  changes("all", () => pick("show", "all"));
  pick("show", "truth");
  changes("object", () => { byId("object").checked = false; });
  changes("mesh", () => { byId("mesh").checked = true; });
  changes("gain", () => { byId("gain").value = 5; });
  changes("open", () => { byId("open").value = 1; controls.reset(); });
  found.tip = viewer.panes[0].pads.some((_, k) => [...Array(400).keys()].some((i) => viewer.pick((i % 20) / 20, Math.floor(i / 20) / 20)?.pad === k));
  found.colors = [...new Set(data.grasps.map((_, i) => { controls.choose(i); return look().full > 0.01; }))];
  found.glError = gl.getError();
  document.body.dataset.check = JSON.stringify(found);
}
if (controls && location.hash === "#check") check();

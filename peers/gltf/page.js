// Shows a model in three.js from its own camera: page.html?model=room.glb&width=640&height=480.
//
// Nothing is added: no lights, no tone mapping, no environment. Without width and height the picture fills the window and the mouse
// rotates the camera; with them it is drawn once in that size, and `window.picture` is a promise of it as a data URL.

import { Box3, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

const asked = new URLSearchParams(location.search);
const size = [Number(asked.get("width")), Number(asked.get("height"))];
const isFixed = size[0] > 0 && size[1] > 0;

// By default three.js writes sRGB without tone mapping.
const renderer = new WebGLRenderer({ antialias: !isFixed, preserveDrawingBuffer: isFixed });
document.body.append(renderer.domElement);

/** The model's camera; without one, a camera that shows the whole model. */
function cameraOf(model) {
  if (model.cameras.length > 0) return model.cameras[0];
  const bounds = new Box3().setFromObject(model.scene);
  const centre = bounds.getCenter(new Vector3());
  const away = bounds.getSize(new Vector3()).length();
  const camera = new PerspectiveCamera(50, 1, 0.01 * away, 4 * away);
  camera.position.copy(centre).add(new Vector3(0, 0, away));
  camera.lookAt(centre);
  return camera;
}

async function show() {
  const model = await new GLTFLoader().loadAsync(asked.get("model"));
  const scene = new Scene();
  scene.add(model.scene);
  const camera = cameraOf(model);
  scene.updateMatrixWorld(true);
  if (isFixed) {
    renderer.setPixelRatio(1);
    renderer.setSize(...size);
    renderer.render(scene, camera);
    return renderer.domElement.toDataURL("image/png");
  }
  const controls = new OrbitControls(camera, renderer.domElement);
  // The camera of a room rotates in place: an orbit would cross the walls. Dragging moves the room along.
  if (model.cameras.length > 0) {
    controls.target.copy(camera.position).addScaledVector(camera.getWorldDirection(new Vector3()), 0.1);
    controls.rotateSpeed = -0.4;
  }
  const draw = () => {
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(innerWidth, innerHeight);
    camera.aspect = innerWidth / innerHeight;
    camera.updateProjectionMatrix();
    renderer.render(scene, camera);
  };
  controls.addEventListener("change", draw);
  addEventListener("resize", draw);
  draw();
}

window.picture = show();

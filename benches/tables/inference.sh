# A pass of the network beside PyTorch and ONNX Runtime

# Times of message passing and of all 50 loads of a grasp in the engine, PyTorch and ONNX Runtime, with the same weights
# and graphs of the same size.
inference() {
    local set=$OUT/inference_$commit
    tactus dataset scenes/lemon.ron --grasps 1 --frames 50 -o "$set" > /dev/null || [ $? -eq 1 ]
    tactus eval "$set" --split all --extrapolate --model universe --dump "$set.npz" > /dev/null
    echo '```text'
    TACTUS_MODEL=models/universe cargo bench -q --bench inference | sed -n 1,3p
    "$python" benches/torch_inference.py models/universe "$set.npz"
    echo '```'
}

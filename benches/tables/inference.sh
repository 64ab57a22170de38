# A pass of the network beside PyTorch and ONNX Runtime

# Message passing and all 50 loads of a grasp by the engine, PyTorch and ONNX Runtime: the same weights, graphs of the same size.
inference() {
    local set=$OUT/inference_$commit
    tactus dataset scenes/lemon.ron --grasps 1 --frames 50 -o "$set" > /dev/null || [ $? -eq 1 ]
    tactus eval "$set" --split all --extrapolate --model universe --dump "$set.npz" > /dev/null
    echo '```text'
    TACTUS_MODEL=models/universe cargo bench -q --bench inference | sed -n 1,3p
    "$python" benches/torch_inference.py models/universe "$set.npz"
    echo '```'
}

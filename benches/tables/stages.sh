# A prediction by stage, beside the least time of its arithmetic

stages() { cargo bench -q --bench prediction; }

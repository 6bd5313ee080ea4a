    const @kind *watched = own;
    watched_step(@{entry}_step, own, &watched->statistics, &watched->alone, &watched->result, @n_x,
            state->memory[state->at], memory, state->watch, late, time, y, told, estimate->flagged);

void dust(float x, out float result)
{
    result = x;
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j)
            for (int k = 0; k < 2; ++k)
                result = sin(result + 1.0);
}

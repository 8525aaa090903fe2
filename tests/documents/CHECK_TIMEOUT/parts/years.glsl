void dust(float x, out float result)
{
    result = x;
    for (int i = 0; i < 60000; ++i)
        for (int j = 0; j < 60000; ++j)
            for (int k = 0; k < 60000; ++k)
                result = sin(result + 1.0);
}

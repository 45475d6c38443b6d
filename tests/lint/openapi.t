#!/usr/bin/perl
# openapi.yaml says what the route table says: paths, methods, statuses; and the parameters of the
# engine are those of the process description.
use strict;
use warnings;
use FindBin;
use lib "$FindBin::Bin/../support";
use Test::More;
use Vt;

my $yaml = Vt::slurp("$FindBin::Bin/../../openapi.yaml");

# The part of YAML that the file keeps to: block mappings by indentation, no tabs.
my (%operations, %parameters, $section, $path, $operation, $in_responses, $components);
for my $line (split /\n/, $yaml) {
    if ($line =~ /^(\w+):/) { $section = $1; $components = '' }
    elsif ($section eq 'paths' && $line =~ m{^  (/\S*):$}) { $path = $1 }
    elsif ($section eq 'paths' && $line =~ /^    (get|post|delete|put|patch|head|options):$/) {
        $operation = uc "$1" . " $path";
        $operation = uc($1) . " $path";
        $operations{$operation} = {};
        $in_responses = 0;
    } elsif ($section eq 'paths' && $line =~ /^      (\w+):/) { $in_responses = $1 eq 'responses' }
    elsif ($section eq 'paths' && $in_responses && $line =~ /^        "(\d+)":$/) {
        $operations{$operation}{$1} = 1;
    } elsif ($section eq 'components' && $line =~ /^  (\w+):$/) { $components = $1 }
    elsif ($section eq 'components' && $components eq 'parameters' && $line =~ /^    (\w+):/) {
        $parameters{$1} = 1;
    }
}
like $yaml, qr/\Aopenapi: 3\.0\.3$/m, 'it is OpenAPI 3.0.3';
unlike $yaml, qr/\t/, 'it has no tabs';
my %references = map { $_ => 1 } $yaml =~ m{\$ref: "#/components/(\w+/\w+)"}g;
for my $reference (sort keys %references) {
    my ($kind, $name) = split m{/}, $reference;
    like $yaml, qr/^  $kind:\n(?:(?:    .*)?\n)*?    $name:/m, "$reference is defined";
}

my (undef, undef, $printed) = Vt::run('--print-routes');
my %routes;
for my $line (split /\n/, $printed) {
    my ($method, $route, @codes) = split / /, $line;
    $routes{"$method $route"} = { map { $_ => 1 } @codes };
}
cmp_ok scalar(keys %routes), '>', 10, 'there is a route table';
is_deeply [sort keys %operations], [sort keys %routes], 'every route is documented, and no other';
for my $route (sort keys %routes) {
    is_deeply [sort keys %{ $operations{$route} // {} }], [sort keys %{ $routes{$route} }],
        "$route: the same statuses";
}

my $daemon = Vt->start;
my $inputs = json($daemon->get('/v1/processes/resample'))->{inputs};
for my $name (grep { $_ ne 'cloud' && $_ ne 'input' } sort keys %$inputs) {
    ok $parameters{$name}, "parameter $name is documented";
}
SKIP: {
    skip 'python3 with yaml is not installed', 1
        if system('python3 -c "import yaml" 2>/dev/null') != 0;
    is system('python3', '-c', 'import sys, yaml; yaml.safe_load(open(sys.argv[1]))',
        "$FindBin::Bin/../../openapi.yaml"), 0, 'it is YAML';
}
is $daemon->stop, 0, 'the daemon ends with 0';
done_testing;
